#include "nepho/run_main.h"

#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "base/patient_caller.h"
#include "nepho/bench.h"
#include "nepho/cmd_info.h"
#include "nepho/compare_pictures.h"
#include "nepho/probe.h"
#include "nepho/program.h"
#include "nepho/render_scene.h"
#include "nepho/scene_sources.h"
#include "render/debug_views.h"
#include "render/output_layers.h"

namespace nepho {

int run_main(int argc, char** argv, const RasterAccess& rasters) {
  std::ios::sync_with_stdio(false);
  const int status = run_program(
      {argv + 1, argv + argc},
      {.render = [&](const Scene& scene, const RenderOutputs& outputs) { render_scene(scene, outputs, rasters); },
       .compare = compare_pictures,
       .bench = [&](const BenchRequest& request, std::ostream& out) { return run_bench(request, rasters, out); },
       .probe = run_probe,
       .info = [&](bool as_json, std::ostream& out) { print_info(as_json, out, rasters); },
       .open_weather = [&](const Scene& scene) { return open_weather(rasters, scene); },
       .open_terrain = [&](const Scene& scene) { return open_terrain(rasters, scene); },
       .layer_names = known_layers(),
       .debug_views = known_debug_views(),
       .probe_kinds = probe_kind_names(),
       .in = std::cin,
       .out = std::cout,
       .err = std::cerr});
  if (calls_left_behind()) {
    // A source that hangs may hold locks that the usual clean-up would wait for. All is written by now.
    std::cout.flush();
    std::cerr.flush();
    std::fflush(nullptr);
    std::_Exit(status);
  }
  return status;
}

}  // namespace nepho
