#include "base/files.h"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

#include "base/error.h"

namespace nepho {
namespace fs = std::filesystem;

namespace {
fs::path temporary_beside(const fs::path& path) {
  fs::path name = path.filename();
  return path.parent_path() / fmt::format(".{}.{}.tmp{}", name.stem().string(), ::getpid(), name.extension().string());
}
std::string env(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}
}  // namespace

void write_whole_file(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  require_writable(path);
  const fs::path temporary = temporary_beside(path);
  std::error_code ignored;
  try {
    write(temporary);
    fs::rename(temporary, path);
  } catch (const fs::filesystem_error& e) {
    fs::remove(temporary, ignored);
    throw fail(ErrorKind::failure, "{}: cannot be written ({})", path.string(), e.code().message());
  } catch (...) {
    fs::remove(temporary, ignored);
    throw;
  }
}

void require_writable(const fs::path& path) {
  std::error_code ec;
  if (path.filename().empty() || fs::is_directory(path, ec))
    throw fail(ErrorKind::failure, "{}: is a folder; name a file in it", path.string());
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ec))
    throw fail(ErrorKind::failure, "{}: cannot be written, there is no folder {}", path.string(), folder.string());
  const fs::path probe = temporary_beside(path);
  {
    std::ofstream file(probe, std::ios::binary);
    if (!file) throw fail(ErrorKind::failure, "{}: cannot be written ({})", path.string(), std::strerror(errno));
  }
  fs::remove(probe, ec);
}

void write_text_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size()));
  file.close();
  if (!file) throw fail(ErrorKind::failure, "{}: cannot be written ({})", path.string(), std::strerror(errno));
}

std::string read_text_file(const fs::path& path) {
  std::error_code ec;
  if (!fs::exists(path, ec)) throw fail(ErrorKind::input, "{}: no such file", path.string());
  if (fs::is_directory(path, ec)) throw fail(ErrorKind::input, "{}: is a folder, not a file", path.string());
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail(ErrorKind::input, "{}: cannot be read ({})", path.string(), std::strerror(errno));
  std::ostringstream all;
  all << file.rdbuf();
  return std::move(all).str();
}

fs::path cache_dir() {
  fs::path dir;
  if (!env("NEPHO_CACHE").empty())
    dir = env("NEPHO_CACHE");
  else if (!env("XDG_CACHE_HOME").empty())
    dir = fs::path(env("XDG_CACHE_HOME")) / "nephoscope";
  else if (!env("HOME").empty())
    dir = fs::path(env("HOME")) / ".cache" / "nephoscope";
  if (dir.empty()) return {};
  std::error_code ec;
  fs::create_directories(dir, ec);
  return ec ? fs::path{} : dir;
}

fs::path data_dir() {
  if (!env("NEPHO_DATA").empty()) return env("NEPHO_DATA");
  std::error_code ec;
  const fs::path exe = fs::read_symlink("/proc/self/exe", ec);
  if (!ec) {
    const fs::path shared = exe.parent_path().parent_path() / "share" / "nephoscope";
    if (fs::is_directory(shared, ec)) return shared;
  }
  return fs::path(NEPHO_SOURCE_DIR) / "data";
}

}  // namespace nepho
