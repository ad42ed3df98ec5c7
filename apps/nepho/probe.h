#pragma once
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace nepho {

struct TerrainSources;
struct WeatherSources;

/// What `nepho probe` was told besides the kind. Kinds of plain geometry and astronomy ignore it; kinds that evaluate
/// the renderer take its scene and device.
struct ProbeOptions {
  Scene scene;
  std::string device;  ///< as `--device`; empty: the best one
  /// Opens what the weather of a scene is made from; kinds that look at clouds call it. Empty: nothing to open.
  std::function<WeatherSources(const Scene&)> open_weather;
  /// The same of the ground; empty: the plain ellipsoid.
  std::function<TerrainSources(const Scene&)> open_terrain = {};
};

/// Evaluates the program's own functions on the rows of a CSV table. Finds its input columns by name, in any order;
/// writes `id` where given, the inputs as they were, and the results with 17 significant digits; other columns are
/// dropped. Blank lines are skipped, a header without rows gives a header, and an input column that may be left out may
/// also be blank in some rows. Returns the exit status 0. Throws Error(usage) for an unknown kind, naming the known
/// ones; Error(input) naming line and column for a missing column or a bad value; Error(failure) when the output cannot
/// be written. Nothing is written unless all rows are good.
int run_probe(const std::string& kind, std::istream& in, std::ostream& out, const ProbeOptions& options = {});

/// Names of all kinds, for help texts.
std::vector<std::string> probe_kind_names();

}  // namespace nepho
