#include "nepho/cmd_compare.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/error.h"
#include "base/files.h"
#include "scene/parameter_text.h"
#include "scene/scene_validate.h"

namespace nepho {

namespace {

const std::vector<std::string> kMasks = {"none", "cloud"};

std::vector<std::string> tone_curves() { return parameter_field("render.tone_curve").choices; }

void require_choice(const char* option, const std::string& value, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    throw fail(ErrorKind::usage, "{}: {}", option, no_choice(value, choices));
}

bool ends_in_png(std::string path) {
  std::transform(path.begin(), path.end(), path.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return path.ends_with(".png");
}

}  // namespace

void CompareCommand::add_to(CLI::App& command) {
  command.add_option("a", a_, "the picture to judge, an EXR with R, G, B in cd/m2")->required()->type_name("A.exr");
  command.add_option("b", b_, "the reference that it is measured against, of the same size")
      ->required()
      ->type_name("B.exr");
  command
      .add_option("--mask", mask_,
                  "pixels that count: cloud (cloud.transmittance < 0.99 in B) or none, all of them; default: none")
      ->type_name("NAME")
      ->take_last();
  command
      .add_option("--exposure", exposure_,
                  "EV100 of both pictures for psnr_db, ssim and flip; default: auto, as B would be exposed")
      ->type_name("EV|auto")
      ->take_last();
  command
      .add_option("--tone-curve", tone_curve_,
                  fmt::format("tone curve of both pictures for psnr_db, ssim and flip: {}; default: that of B's scene",
                              fmt::join(tone_curves(), ", ")))
      ->type_name("NAME")
      ->take_last();
  command
      .add_option("--json", json_, "write the numbers as JSON, - to standard output; without it, a table is printed")
      ->type_name("FILE.json")
      ->take_last();
  command
      .add_option("--heatmap", heatmap_,
                  "picture of the relative error of luminance: blue where A is too dark, white equal, red too bright, "
                  "full at 50 %, grey outside of the mask")
      ->type_name("OUT.png")
      ->take_last();
  command.footer(
      "Linear measures (luminance): rmse, mean_relative_error, bias, noise_of_b. Tone mapped, with one exposure and "
      "curve\n"
      "for both pictures: psnr_db, ssim, flip. docs/compare.md says what each means.");
}

void CompareCommand::run(const Program& program) const {
  CompareRequest request;
  request.a = a_;
  request.b = b_;
  require_choice("--mask", mask_, kMasks);
  request.mask = mask_;
  if (exposure_ != "auto") {
    Scene scene;  // the parameter's own range
    scene.render.exposure_ev100 = parse_number(exposure_, "--exposure");
    validate(scene, ErrorKind::usage, [](const std::string&) { return "--exposure"; });
    request.exposure_ev100 = scene.render.exposure_ev100;
  }
  if (!tone_curve_.empty()) require_choice("--tone-curve", tone_curve_, tone_curves());
  request.tone_curve = tone_curve_;
  if (!heatmap_.empty() && !ends_in_png(heatmap_))
    throw fail(ErrorKind::usage, "--heatmap: '{}' does not end in .png", heatmap_);
  for (const std::string& output : {json_, heatmap_})
    if (!output.empty() && output != "-") require_writable(output);
  request.json = json_;
  request.heatmap = heatmap_;
  program.compare(request, program.out);
}

}  // namespace nepho
