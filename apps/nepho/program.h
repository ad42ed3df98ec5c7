#pragma once
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "nepho/bench.h"
#include "nepho/compare_pictures.h"
#include "nepho/probe.h"
#include "nepho/render_scene.h"

namespace nepho {

/// What the commands call, so that the command line can be tested without a device, and the streams they use.
struct Program {
  std::function<void(const Scene&, const RenderOutputs&)> render = {};
  std::function<void(const CompareRequest&, std::ostream& out)> compare = {};
  std::function<std::vector<BenchResult>(const BenchRequest&, std::ostream& out)> bench = {};
  std::function<int(const std::string& kind, std::istream&, std::ostream&, const ProbeOptions&)> probe = {};
  std::function<void(bool as_json, std::ostream&)> info = {};
  std::function<WeatherSources(const Scene&)> open_weather = {};  ///< for probes; empty: there are no rasters
  std::function<TerrainSources(const Scene&)> open_terrain = {};  ///< the same
  std::vector<std::string> layer_names = {};                      ///< that --aov knows
  std::vector<std::string> debug_views = {};                      ///< that --debug knows
  std::vector<std::string> probe_kinds = {};                      ///< for the help of `nepho probe`
  std::istream& in;
  std::ostream& out;  ///< results
  std::ostream& err;  ///< messages
};

/// Runs `nepho` with the arguments after the program's name. Returns the exit status; throws nothing.
int run_program(const std::vector<std::string>& arguments, const Program& program);

}  // namespace nepho
