#include "nepho/compare_pictures.h"

#include <nlohmann/json.hpp>
#include <ostream>

#include "base/error.h"
#include "base/files.h"
#include "base/log.h"
#include "compare/compare_images.h"
#include "io/exr.h"
#include "io/png.h"
#include "scene/scene_json.h"
#include "tone/white_balance.h"

namespace nepho {

namespace {

/// The render settings of the scene in a picture's header; defaults where there is none, or none that this version
/// reads.
RenderParams settings_of(const ExrFile& picture, const std::string& name) {
  const auto scene = picture.attributes.strings.find("nepho:scene");
  if (scene == picture.attributes.strings.end()) return {};
  try {
    return scene_from_json(scene->second, name + ": nepho:scene").render;
  } catch (const Error& e) {
    log_warning("{}; the default tone settings are used", e.what());
    return {};
  }
}

ExrFile read_picture(const std::filesystem::path& path) {
  ExrFile picture = read_exr(path);
  if (!picture.attributes.rec709)
    log_warning("{}: its chromaticities are not those of Rec. 709; its R, G, B are taken as if they were",
                path.string());
  return picture;
}

template <typename T>
nlohmann::ordered_json json_of(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

std::string to_json(const CompareRequest& request, const std::string& tone_curve, const Comparison& c) {
  nlohmann::ordered_json j;
  j["a"] = request.a.string();
  j["b"] = request.b.string();
  j["mask"] = request.mask;
  j["pixels"] = c.pixels;
  j["exposure_ev100"] = c.exposure_ev100;
  j["tone_curve"] = tone_curve;
  j["rmse"] = c.rmse;
  j["mean_relative_error"] = json_of(c.mean_relative_error);
  j["bias"] = json_of(c.bias);
  j["noise_of_b"] = json_of(c.noise_of_b);
  j["within_3_sigma"] = json_of(c.within_3_sigma);
  j["largest_z"] = json_of(c.largest_z);
  j["psnr_db"] = json_of(c.psnr_db);
  j["ssim"] = json_of(c.ssim);
  j["flip"] = c.flip;
  j["measured_on"] = {{"linear", {"rmse", "mean_relative_error", "bias", "noise_of_b", "within_3_sigma", "largest_z"}},
                      {"tone_mapped", {"psnr_db", "ssim", "flip"}}};
  // Names of files may be in any encoding.
  return j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

void print_table(const CompareRequest& request, const std::string& tone_curve, const Comparison& c, std::ostream& out) {
  const auto percent = [](const std::optional<double>& share, const char* sign) {
    if (!share) return std::string("-");
    return sign[0] == '+' ? fmt::format("{:+.3f} %", 100.0 * *share) : fmt::format("{:.3f} %", 100.0 * *share);
  };
  const auto row = [&](const char* name, const std::string& value, const char* what) {
    out << fmt::format("  {:<20} {:>14}  {}\n", name, value, what);
  };
  out << fmt::format("{} against {}: {} pixels{}\n", request.a.string(), request.b.string(), c.pixels,
                     request.mask == "none" ? "" : fmt::format(" (mask {})", request.mask));
  out << "linear luminance\n";
  row("rmse", fmt::format("{:.6g}", c.rmse), "cd/m2");
  row("mean_relative_error", percent(c.mean_relative_error, ""), "sum |A - B| / sum B");
  row("bias", percent(c.bias, "+"), "sum (A - B) / sum B");
  row("noise_of_b", percent(c.noise_of_b, ""), "95 % of B's pixels have this standard error or less");
  if (c.within_3_sigma) {
    row("within_3_sigma", percent(c.within_3_sigma, ""), "pixels that differ by 3 combined standard errors at most");
    row("largest_z", fmt::format("{:.3f}", *c.largest_z), "standard errors of the pixel that differs most");
  }
  out << fmt::format("tone mapped (curve {}, EV100 {:.3f})\n", tone_curve, c.exposure_ev100);
  row("psnr_db", c.psnr_db ? fmt::format("{:.3f}", *c.psnr_db) : "inf", "dB");
  row("ssim", c.ssim ? fmt::format("{:.5f}", *c.ssim) : "-", "1: equal");
  row("flip", fmt::format("{:.5f}", c.flip), "0: equal");
}

}  // namespace

void compare_pictures(const CompareRequest& request, std::ostream& out) {
  const ExrFile a = read_picture(request.a), b = read_picture(request.b);
  const RenderParams settings = settings_of(b, request.b.string());
  const std::string tone_curve = request.tone_curve.empty() ? settings.tone_curve : request.tone_curve;
  CompareOptions options;
  options.name_a = request.a.string();
  options.name_b = request.b.string();
  options.mask = request.mask == "cloud" ? CompareMask::cloud : CompareMask::none;
  options.exposure_ev100 = request.exposure_ev100;
  options.limits = {.min_ev100 = settings.min_ev100,
                    .max_ev100 = settings.max_ev100,
                    .compensation_ev = settings.exposure_compensation_ev};
  options.tone_curve = tone_curve_id(tone_curve);
  options.white_balance = glm::mat3(rec709_white_balance(settings.white_balance_k));
  options.heatmap = !request.heatmap.empty();
  const Comparison comparison = compare_images(a.image, b.image, options);

  if (options.heatmap) write_png(request.heatmap, b.image.width, b.image.height, comparison.heatmap_rgb);
  if (request.json.empty()) {
    print_table(request, tone_curve, comparison, out);
  } else if (request.json == "-") {
    out << to_json(request, tone_curve, comparison);
  } else {
    write_whole_file(request.json, [&](const std::filesystem::path& temporary) {
      write_text_file(temporary, to_json(request, tone_curve, comparison));
    });
  }
}

}  // namespace nepho
