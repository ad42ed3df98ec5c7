#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nepho {

/// A scene from JSON text (docs/scene.md). Absent members keep their defaults; the time becomes canonical UTC.
/// `source` names the text in messages. Throws Error(input), one line: broken JSON with line and column; an unknown or
/// repeated key with its path and the nearest known key; a wrong type or a value out of range with path and range.
Scene scene_from_json(const std::string& text, const std::string& source);

/// As above, from a file. Relative paths of rasters and textures are taken relative to the file's folder.
Scene load_scene(const std::filesystem::path& path);

/// All members, in the order of docs/parameters.md, absent optional ones as null. scene_from_json() of it gives an
/// equal scene when the time is canonical.
std::string scene_to_json(const Scene& scene);

/// Writes a scene file whole or not at all. Paths inside the file's folder become relative to it, others
/// absolute, so that load_scene() finds the same files from anywhere. Throws Error(failure).
void save_scene(const std::filesystem::path& path, const Scene& scene);

/// Reads the members of a scene that the JSON object in `text` has over those of `scene` (places.h). `what` names the
/// text, as `source` above.
void merge_scene_json(Scene& scene, const std::string& text, const std::string& what);

/// Whether a raster's name is a path of this machine, and no GDAL connection such as "/vsizip/a.zip" or
/// "NETCDF:a.nc:v".
bool is_local_path(const std::string& raster);

/// All files that a scene names and that are paths of this machine: elevation, imagery, weather, noise.
std::vector<std::string> local_files(const Scene& scene);

}  // namespace nepho
