#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace nepho {

/// Writes a file whole or not at all: `write` gets the path of a temporary file beside `path`, which is renamed to
/// `path` when it returns and removed when it throws. Throws Error(failure) when the folder cannot be written.
void write_whole_file(const std::filesystem::path& path,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// Throws Error(failure) with one clear line unless a file could be created at `path` (checked before long work).
void require_writable(const std::filesystem::path& path);

/// Puts bytes into a file as they are. Throws Error(failure) when the disk refuses. Not whole-or-not by itself.
void write_text_file(const std::filesystem::path& path, const std::string& text);

/// All bytes of a file. Throws Error(input) naming the file when it is missing or unreadable.
std::string read_text_file(const std::filesystem::path& path);

/// Folder for caches that may be deleted at any time: $NEPHO_CACHE, else $XDG_CACHE_HOME/nephoscope, else
/// ~/.cache/nephoscope. Created when absent; empty when no such folder can be made (then nothing is cached).
std::filesystem::path cache_dir();

/// Folder of the shipped `data/`: $NEPHO_DATA, else ../share/nephoscope beside the program, else the source tree.
std::filesystem::path data_dir();

}  // namespace nepho
