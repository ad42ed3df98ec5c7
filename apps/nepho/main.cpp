#include <iostream>

#include "nepho/cmd_info.h"
#include "nepho/probe.h"
#include "nepho/program.h"
#include "nepho/render_scene.h"
#include "nepho/scene_sources.h"
#include "render/debug_views.h"
#include "render/output_layers.h"

int main(int argc, char** argv) {
  std::ios::sync_with_stdio(false);
  return nepho::run_program({argv + 1, argv + argc},
                            {.render = nepho::render_scene,
                             .probe = nepho::run_probe,
                             .info = nepho::print_info,
                             .open_weather = [](const nepho::Scene& scene) { return nepho::open_weather(scene); },
                             .layer_names = nepho::known_layers(),
                             .debug_views = nepho::known_debug_views(),
                             .probe_kinds = nepho::probe_kind_names(),
                             .in = std::cin,
                             .out = std::cout,
                             .err = std::cerr});
}
