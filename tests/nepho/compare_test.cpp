#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "io/exr.h"
#include "io/file_test_tools.h"
#include "io/png.h"
#include "nepho/program.h"
#include "scene/scene_json.h"

using namespace nepho;
using test::bytes_of;
using test::TempFolder;

namespace {

struct Run {
  int status = 0;
  std::string out, err;
  std::optional<CompareRequest> request;  ///< that was handed on
};

/// The command line, with the pictures really compared where `compare` is set.
Run run(std::vector<std::string> arguments, bool compare) {
  Run result;
  std::istringstream in;
  std::ostringstream out, err;
  const Program program{.compare =
                            [&](const CompareRequest& request, std::ostream& stream) {
                              result.request = request;
                              if (compare) compare_pictures(request, stream);
                            },
                        .in = in,
                        .out = out,
                        .err = err};
  arguments.insert(arguments.begin(), "compare");
  result.status = run_program(arguments, program);
  result.out = out.str();
  result.err = err.str();
  return result;
}

CompareRequest asked(const std::vector<std::string>& arguments) {
  const Run result = run(arguments, false);
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  REQUIRE(result.request.has_value());
  return *result.request;
}

/// The one line of a failure without its prefix.
std::string failure(const std::vector<std::string>& arguments, int status) {
  const Run result = run(arguments, true);
  CHECK(result.status == status);
  CHECK(result.out.empty());
  const std::string prefix = "nepho: error: ";
  REQUIRE(result.err.starts_with(prefix));
  CHECK(result.err.find('\n') == result.err.size() - 1);
  return result.err.substr(prefix.size(), result.err.size() - prefix.size() - 1);
}

ImageBuffer plain(uint32_t width, uint32_t height, float value, const std::vector<std::string>& extra = {}) {
  ImageBuffer image{.width = width, .height = height, .channels = {}};
  std::vector<std::string> names = {"B", "G", "R"};
  names.insert(names.end(), extra.begin(), extra.end());
  for (const std::string& name : names)
    image.channels.push_back({name, std::vector<float>(size_t{width} * height, value)});
  return image;
}

/// Two pictures of 16 x 12 pixels; A is a tenth brighter.
struct Pair : TempFolder {
  std::string a = (*this / "a.exr").string(), b = (*this / "b.exr").string();
  Pair() {
    write_exr(a, plain(16, 12, 110.0f), {});
    write_exr(b, plain(16, 12, 100.0f), {});
  }
};

}  // namespace

TEST_CASE("compare: options make the request that they say") {
  const CompareRequest plain_request = asked({"a.exr", "b.exr"});
  CHECK(plain_request.a == "a.exr");
  CHECK(plain_request.b == "b.exr");
  CHECK(plain_request.mask == "none");
  CHECK_FALSE(plain_request.exposure_ev100.has_value());
  CHECK(plain_request.tone_curve.empty());
  CHECK(plain_request.json.empty());
  CHECK(plain_request.heatmap.empty());
  const CompareRequest full = asked({"a.exr", "b.exr", "--mask", "cloud", "--exposure", "-2.5", "--tone-curve", "aces",
                                     "--json", "-", "--heatmap", "/tmp/h.PNG"});
  CHECK(full.mask == "cloud");
  CHECK(full.exposure_ev100 == -2.5);
  CHECK(full.tone_curve == "aces");
  CHECK(full.json == "-");
  CHECK(full.heatmap == "/tmp/h.PNG");
  CHECK_FALSE(asked({"a.exr", "b.exr", "--exposure", "auto"}).exposure_ev100.has_value());
}

TEST_CASE("compare: bad options are usage errors with the nearest names") {
  CHECK(failure({"a.exr", "b.exr", "--mask", "clouds"}, 2) ==
        "--mask: 'clouds' is not one of none, cloud; did you mean 'cloud'?");
  CHECK(failure({"a.exr", "b.exr", "--tone-curve", "ages"}, 2) ==
        "--tone-curve: 'ages' is not one of aces, agx, reinhard, linear; did you mean 'aces'?");
  CHECK(failure({"a.exr", "b.exr", "--exposure", "bright"}, 2) == "--exposure: 'bright' is not a number");
  CHECK(failure({"a.exr", "b.exr", "--exposure", "nan"}, 2).starts_with("--exposure: nan is out of range"));
  CHECK(failure({"a.exr", "b.exr", "--heatmap", "h.jpg"}, 2) == "--heatmap: 'h.jpg' does not end in .png");
  CHECK(failure({"a.exr", "b.exr", "--heatmp", "h.png"}, 2) == "'--heatmp' is not expected; did you mean '--heatmap'?");
  CHECK(failure({"a.exr"}, 2).find("b is required") != std::string::npos);
}

TEST_CASE("compare: help names every option and every measure") {
  const Run help = run({"--help"}, true);
  CHECK(help.status == 0);
  for (const char* word : {"--mask", "--exposure", "--tone-curve", "--json", "--heatmap", "rmse", "mean_relative_error",
                           "bias", "noise_of_b", "psnr_db", "ssim", "flip", "agx"})
    CHECK_MESSAGE(help.out.find(word) != std::string::npos, word);
}

TEST_CASE("compare: a table goes to standard output, JSON to a file or standard output instead") {
  const Pair pair;
  const Run table = run({pair.a, pair.b}, true);
  CHECK(table.status == 0);
  CHECK(table.out.find("mean_relative_error") != std::string::npos);
  CHECK(table.out.find("10.000 %") != std::string::npos);

  const std::string file = (pair / "c.json").string();
  const Run quiet = run({pair.a, pair.b, "--json", file, "--exposure", "7", "--tone-curve", "linear"}, true);
  CHECK(quiet.status == 0);
  CHECK(quiet.out.empty());
  CHECK(run({pair.a, pair.b, "--json", "-", "--exposure", "7", "--tone-curve", "linear"}, true).out == bytes_of(file));

  const nlohmann::json j = nlohmann::json::parse(bytes_of(file));
  CHECK(j.at("a") == pair.a);
  CHECK(j.at("b") == pair.b);
  CHECK(j.at("mask") == "none");
  CHECK(j.at("pixels") == 192);
  CHECK(j.at("exposure_ev100") == 7.0);
  CHECK(j.at("tone_curve") == "linear");
  CHECK(j.at("rmse").get<double>() == doctest::Approx(10.0).epsilon(1e-6));
  CHECK(j.at("mean_relative_error").get<double>() == doctest::Approx(0.1).epsilon(1e-6));
  CHECK(j.at("bias").get<double>() == doctest::Approx(0.1).epsilon(1e-6));
  CHECK(j.at("noise_of_b").is_null());
  for (const char* name : {"psnr_db", "ssim", "flip"}) CHECK(std::isfinite(j.at(name).get<double>()));
  CHECK(j.at("measured_on").at("tone_mapped").size() == 3);
}

TEST_CASE("compare: equal pictures have no PSNR: null in JSON, inf in the table") {
  const Pair pair;
  const nlohmann::json j = nlohmann::json::parse(run({pair.b, pair.b, "--json", "-"}, true).out);
  CHECK(j.at("psnr_db").is_null());
  CHECK(j.at("ssim") == 1.0);
  CHECK(j.at("flip") == 0.0);
  CHECK(run({pair.b, pair.b}, true).out.find("inf") != std::string::npos);
}

TEST_CASE("compare: tone curve, white balance and limits of exposure are those of the scene in B") {
  const Pair pair;
  Scene scene;
  scene.render.tone_curve = "reinhard";
  scene.render.min_ev100 = scene.render.max_ev100 = 9.0;
  scene.render.white_balance_k = 8000.0;
  ExrAttributes attributes;
  attributes.strings["nepho:scene"] = scene_to_json(scene);
  write_exr(pair.b, plain(16, 12, 100.0f), attributes);
  const auto measured = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {pair.a, pair.b, "--json", "-"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return nlohmann::json::parse(run(arguments, true).out);
  };
  const nlohmann::json own = measured({});
  CHECK(own.at("tone_curve") == "reinhard");
  CHECK(own.at("exposure_ev100") == 9.0);
  CHECK(measured({"--tone-curve", "agx"}).at("tone_curve") == "agx");
  scene.render.white_balance_k = 6504.0;
  attributes.strings["nepho:scene"] = scene_to_json(scene);
  write_exr(pair.b, plain(16, 12, 100.0f), attributes);
  CHECK(measured({}).at("psnr_db") != own.at("psnr_db"));
  // A scene of another version is no reason to fail.
  attributes.strings["nepho:scene"] = R"({"of_another_version": 1})";
  write_exr(pair.b, plain(16, 12, 100.0f), attributes);
  CHECK(measured({}).at("tone_curve") == "agx");
}

TEST_CASE("compare: the heat map is a picture of the same size") {
  const Pair pair;
  const std::string file = (pair / "h.png").string();
  CHECK(run({pair.a, pair.b, "--heatmap", file}, true).status == 0);
  const ImageBuffer heat = read_png(file);
  CHECK(heat.width == 16);
  CHECK(heat.height == 12);
  // 10 / 105 too bright: reddish.
  CHECK(heat.find("R")->values[0] > heat.find("B")->values[0] + 0.1f);
}

TEST_CASE("compare: pictures that cannot be read or compared are status 3, and no file is written") {
  const Pair pair;
  const std::string gone = (pair / "gone.exr").string(), text = (pair / "text.exr").string();
  const std::string json = (pair / "c.json").string(), heat = (pair / "h.png").string();
  std::ofstream(text) << "no picture";
  const auto fails = [&](const std::string& a, const std::string& b, const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments = {a, b, "--json", json, "--heatmap", heat};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const std::string message = failure(arguments, 3);
    CHECK_FALSE(std::filesystem::exists(json));
    CHECK_FALSE(std::filesystem::exists(heat));
    return message;
  };
  CHECK(fails(gone, pair.b) == gone + ": no such file");
  CHECK(fails(pair.a, text) == text + ": is not an OpenEXR file");
  const std::string other = (pair / "other.exr").string();
  write_exr(other, plain(16, 13, 1.0f), {});
  CHECK(fails(pair.a, other) ==
        pair.a + " has 16x12 pixels and " + other + " 16x13; only pictures of one size can be compared");
  CHECK(fails(pair.a, pair.b, {"--mask", "cloud"}).starts_with(pair.b + ": has no layer cloud.transmittance"));
  write_exr(other, plain(16, 12, 1.0f, {"cloud.transmittance"}), {});
  CHECK(fails(pair.a, other, {"--mask", "cloud"}).starts_with(other + ": no pixel has cloud"));
  ImageBuffer broken = plain(16, 12, 1.0f);
  broken.channels[1].values[5] = std::numeric_limits<float>::quiet_NaN();
  write_exr(other, broken, {});
  CHECK(fails(other, pair.b).starts_with(other + ": 1 of 192 pixels are NaN or infinite"));
  ImageBuffer grey = plain(16, 12, 1.0f);
  grey.channels.resize(1);
  write_exr(other, grey, {});
  CHECK(fails(other, pair.b).starts_with(other + ": has no channels R, G, B (found: B)"));
}

TEST_CASE("compare: an output that cannot be written is status 5 before anything is read") {
  const Pair pair;
  CHECK(failure({"gone.exr", "gone.exr", "--json", (pair / "no/c.json").string()}, 5).find("no/c.json") !=
        std::string::npos);
}
