#include "nepho/program.h"

#include <CLI/CLI.hpp>
#include <istream>
#include <ostream>

#include "base/error.h"
#include "nepho/cmd_bench.h"
#include "nepho/cmd_compare.h"
#include "nepho/cmd_render.h"
#include "nepho/options.h"
#include "scene/scene_schema.h"

namespace nepho {

namespace {

constexpr std::pair<const char*, const char*> kLater[] = {
    {"tour", "a sequence of pictures or a movie along a path"},
    {"map", "georeferenced view from above"},
    {"view", "the viewer"},
};

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

/// The command that was named, the program itself if none was.
const CLI::App* command_of(const CLI::App& app) {
  const std::vector<CLI::App*> named = app.get_subcommands();
  return named.empty() ? &app : named.front();
}

/// What to say about arguments that nothing took: names the first, and what it may have been meant to be.
std::string describe_extras(const CLI::App& app) {
  const CLI::App& command = *command_of(app);
  std::vector<std::string> extras = app.remaining(true);
  const std::string first = extras.empty() ? "" : extras.front();
  std::vector<std::string> known;
  if (first.starts_with("-")) {
    for (const CLI::Option* option : command.get_options())
      if (!option->get_group().empty())
        for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  } else if (&command == &app) {
    for (const CLI::App* other : app.get_subcommands([](const CLI::App*) { return true; }))
      known.push_back(other->get_name());
  }
  const std::string nearest = nearest_name(first.substr(0, first.find('=')), known);
  return fmt::format("'{}' is not expected; {}", first,
                     nearest.empty() ? fmt::format("see {} --help", command.get_name().empty() || &command == &app
                                                                        ? "nepho"
                                                                        : "nepho " + command.get_name())
                                     : fmt::format("did you mean '{}'?", nearest));
}

/// Parses and runs. Failures leave as exceptions.
int run(const std::vector<std::string>& arguments, const Program& program) {
  CLI::App app("Volumetric weather on the real Earth, from the ground to a geostationary satellite.", "nepho");
  app.set_version_flag("--version", "nepho " NEPHO_VERSION);
  app.get_formatter()->column_width(34);
  app.require_subcommand(1);

  RenderCommand render;
  CLI::App* const render_app = app.add_subcommand("render", "draw a scene as PNG and EXR");
  render.add_to(*render_app, program);

  CompareCommand compare;
  CLI::App* const compare_app = app.add_subcommand("compare", "measure how far a picture is from a reference");
  compare.add_to(*compare_app);

  BenchCommand bench;
  CLI::App* const bench_app = app.add_subcommand("bench", "measure times and memory of scenes, pass by pass");
  bench.add_to(*bench_app);

  std::string kind;
  SceneOptions probe_scene;
  std::string probe_device;
  CLI::App* const probe_app =
      app.add_subcommand("probe", "evaluate the program's own functions on a CSV table, standard input to output");
  probe_app->add_option("kind", kind, fmt::format("what to evaluate: {}", fmt::join(program.probe_kinds, ", ")))
      ->required()
      ->type_name("KIND");
  probe_scene.add_to(*probe_app);
  probe_app->add_option("--device", probe_device, kDeviceHelp)->type_name("NAME");

  bool as_json = false;
  CLI::App* const info_app = app.add_subcommand("info", "devices, versions, data found, named places");
  info_app->add_flag("--json", as_json, "as JSON");

  bool parameters = false;
  CLI::App* const schema_app = app.add_subcommand("schema", "the JSON Schema of scene files");
  schema_app->add_flag("--parameters", parameters, "instead, the table of parameters in docs/parameters.md");

  for (const auto& [name, what] : kLater)
    app.add_subcommand(name, fmt::format("{} (not supported yet)", what))->prefix_command();

  try {
    std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
    app.parse(reversed);
  } catch (const CLI::Success& e) {  // --help, --version
    app.exit(e, program.out, program.err);
    return 0;
  } catch (const CLI::ExtrasError&) {
    throw Error(ErrorKind::usage, describe_extras(app));
  } catch (const CLI::ParseError& e) {
    if (command_of(app) == &app)
      throw Error(ErrorKind::usage,
                  app.remaining().empty() ? "a command is missing; see nepho --help" : describe_extras(app));
    throw Error(ErrorKind::usage, one_line(e.what()));
  }

  for (const auto& [name, what] : kLater)
    if (app.got_subcommand(name)) {
      program.err << "nepho " << name << ": not supported yet\n";
      return static_cast<int>(ErrorKind::usage);
    }
  int status = 0;
  if (*render_app) {
    render.run(program);
  } else if (*compare_app) {
    compare.run(program);
  } else if (*bench_app) {
    bench.run(program);
  } else if (*probe_app) {
    const ProbeOptions options{.scene = probe_scene.scene(),
                               .device = probe_device,
                               .open_weather = program.open_weather,
                               .open_terrain = program.open_terrain};
    require_inputs(options.scene);
    status = program.probe(kind, program.in, program.out, options);
  } else if (*info_app) {
    program.info(as_json, program.out);
  } else {
    program.out << (parameters ? parameters_markdown() : scene_schema());
  }
  if (!program.out.flush()) throw Error(ErrorKind::failure, "standard output cannot be written");
  return status;
}

}  // namespace

int run_program(const std::vector<std::string>& arguments, const Program& program) {
  const auto failed = [&](ErrorKind kind, const std::string& message) {
    program.err << "nepho: error: " << one_line(message) << '\n';
    return static_cast<int>(kind);
  };
  try {
    return run(arguments, program);
  } catch (const Error& e) {
    return failed(e.kind(), e.what());
  } catch (const std::bad_alloc&) {
    return failed(ErrorKind::failure, "out of memory");
  } catch (const std::exception& e) {
    return failed(ErrorKind::failure, e.what());
  }
}

}  // namespace nepho
