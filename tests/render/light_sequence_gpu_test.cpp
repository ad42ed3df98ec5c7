// Light inside clouds from frame to frame (docs/light.md, 'In sequences').
#include <cmath>
#include <functional>

#include "render/reference_scene.h"

namespace nepho {
namespace {
using namespace test;

constexpr double kFps = 60.0;

Scene light_scene(Extent2D size = {64, 36}) {
  CloudParams clouds = half_sky("cumulus");
  clouds.layers[0].wind_east_mps = 10.0;
  Scene scene = reference_scene(clouds, size);
  scene.time = "2026-06-21T00:42:00Z";
  scene.camera.height_m = 1700.0;
  scene.camera.heading_deg = 0.0;
  scene.camera.pitch_deg = -2.0;
  scene.clouds.shadows.enabled = false;  // their maps take longer than all else here
  scene.render.quality = "medium";
  scene.render.frames = 1;
  scene.terrain.shadows = false;
  scene.shafts.method = "none";
  return scene;
}

struct Drawn {
  std::vector<float> rgb;
  std::vector<uint8_t> shown;
  uint32_t cells = 0, fresh = 0, refresh = 0;
};

Drawn draw(Renderer& renderer, uint32_t number, bool live = false) {
  const RenderResult r = renderer.render({.frame_number = number, .live = live, .count_work = true});
  Drawn out;
  for (const char* name : {"R", "G", "B"})
    out.rgb.insert(out.rgb.end(), channel(r.layers, name).begin(), channel(r.layers, name).end());
  out.shown = r.display_rgb;
  out.cells = renderer.timings().light_cells;
  out.fresh = renderer.timings().light_fresh;
  out.refresh = renderer.timings().light_refresh;
  return out;
}

double psnr(const std::vector<uint8_t>& a, const std::vector<float>& b) {
  REQUIRE(a.size() == b.size());
  double sum = 0.0;
  for (size_t k = 0; k < a.size(); ++k) sum += std::pow(static_cast<double>(a[k]) - static_cast<double>(b[k]), 2.0);
  return sum > 0.0 ? 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.size()) / sum) : 99.0;
}

/// Root of the mean square difference over the mean of b.
double apart(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0, mean = 0.0;
  for (size_t k = 0; k < a.size(); ++k) {
    sum += std::pow(static_cast<double>(a[k]) - static_cast<double>(b[k]), 2.0);
    mean += static_cast<double>(b[k]);
  }
  return std::sqrt(sum * static_cast<double>(a.size())) / mean;
}

/// The last of `frames` frames; and the same traced anew, with several seeds.
struct Pictures {
  Drawn kept;
  std::vector<Drawn> anew;
};
Pictures against_anew(GpuFixture& f, const Scene& scene, uint32_t frames, uint32_t seeds,
                      const std::function<CameraParams(double seconds)>& camera) {
  const UtcInstant begin = parse_utc(scene.time);
  Pictures out;
  const auto place = [&](Renderer& renderer, uint32_t frame) {
    renderer.set_time(begin.plus_seconds(frame / kFps));
    renderer.set_camera(camera(frame / kFps));
  };
  Renderer sequence(f.device, {}, scene);
  for (uint32_t i = 0; i < frames; ++i) {
    place(sequence, i);
    out.kept = draw(sequence, i);
  }
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    Scene other = scene;
    other.render.seed = 1000 + seed;
    Renderer renderer(f.device, {}, other);
    place(renderer, frames - 1);
    out.anew.push_back(draw(renderer, 0));
  }
  return out;
}

std::vector<float> mean_shown(const std::vector<Drawn>& drawn) {
  std::vector<float> mean(drawn[0].shown.size(), 0.0f);
  for (const Drawn& d : drawn)
    for (size_t k = 0; k < mean.size(); ++k)
      mean[k] += static_cast<float>(d.shown[k]) / static_cast<float>(drawn.size());
  return mean;
}

}  // namespace

TEST_CASE("gpu: a still camera traces no cell of light twice, and its light nears the mean of many") {
  GpuFixture f;
  const Scene scene = light_scene();
  // The mean of pictures with other seeds.
  std::vector<float> mean;
  constexpr uint32_t kSeeds = 4;
  for (uint32_t seed = 0; seed < kSeeds; ++seed) {
    Scene other = scene;
    other.render.seed = 1000 + seed;
    Renderer renderer(f.device, {}, other);
    const Drawn drawn = draw(renderer, 0);
    mean.resize(drawn.rgb.size(), 0.0f);
    for (size_t k = 0; k < mean.size(); ++k) mean[k] += drawn.rgb[k] / static_cast<float>(kSeeds);
  }
  Renderer renderer(f.device, {}, scene);
  const Drawn first = draw(renderer, 0);
  CHECK(first.fresh == first.cells);
  CHECK(first.cells > 500);
  Drawn last;
  uint32_t paths = 0;
  for (uint32_t i = 1; i <= 24; ++i) {
    last = draw(renderer, i);
    CHECK(last.fresh == 0);
    CHECK(last.cells == first.cells);
    CHECK(last.refresh > first.cells / 8);
    CHECK(last.refresh < first.cells / 2);
    if (i <= 4) paths += last.refresh;
  }
  CHECK(paths == first.cells);  // each gets one in four frames
  const double then = apart(first.rgb, mean), now = apart(last.rgb, mean);
  MESSAGE(first.cells, " cells; from the mean of ", kSeeds, ": ", 100.0 * then, " % at first, ", 100.0 * now,
          " % after 24 frames");
  CHECK(now < 0.8 * then);
  const Drawn again = draw(renderer, 0);  // a still again
  CHECK(again.rgb == first.rgb);
}

TEST_CASE("gpu: light kept from frame to frame is that traced anew, for cameras that turn and fly") {
  GpuFixture f;
  const Scene scene = light_scene();
  struct Flight {
    std::string name;
    std::function<CameraParams(double)> camera;
  };
  const Flight flights[] = {{"turns by 90 degrees a second",
                             [&](double s) {
                               CameraParams c = scene.camera;
                               c.heading_deg = 90.0 * s;
                               return c;
                             }},
                            {"flies at 250 m/s", [&](double s) {
                               CameraParams c = scene.camera;
                               c.lat_deg += 250.0 * s / 111e3;
                               return c;
                             }}};
  for (const Flight& flight : flights) {
    CAPTURE(flight.name);
    const Pictures p = against_anew(f, scene, 16, 3, flight.camera);
    // Light traced anew differs, too, by the noise of its few paths: from the mean of others by `anew`.
    const double kept = psnr(p.kept.shown, mean_shown(p.anew));
    double anew = 0.0;
    for (size_t k = 0; k < p.anew.size(); ++k) {
      std::vector<Drawn> others = p.anew;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      anew += psnr(p.anew[k].shown, mean_shown(others)) / static_cast<double>(p.anew.size());
    }
    MESSAGE(flight.name, ": ", kept, " dB, traced anew ", anew, " dB; ", p.kept.fresh, " of ", p.kept.cells,
            " cells traced in full, ", p.kept.refresh, " with a path more");
    CHECK(kept > 38.0);
    CHECK(kept > anew);
    CHECK(p.kept.fresh < p.kept.cells / 4);
  }
}

TEST_CASE("gpu: live pictures have the light of stills, nearly, from the first on") {
  GpuFixture f;
  Scene scene = light_scene(full_size() ? Extent2D{160, 90} : Extent2D{64, 36});
  if (full_size()) scene.render.quality = "high";
  constexpr uint32_t kFrames = 24;
  std::vector<Drawn> stills;
  for (const uint32_t seed : {1000u, 1001u}) {
    Scene other = scene;
    other.render.seed = seed;
    Renderer renderer(f.device, {}, other);
    stills.push_back(draw(renderer, 0));
  }
  const std::vector<float> mean = mean_shown(stills);
  const auto bias = [&](const Drawn& d) {
    double sum = 0.0, of = 0.0;
    for (size_t k = 0; k < d.rgb.size(); ++k) {
      const double still = 0.5 * static_cast<double>(stills[0].rgb[k] + stills[1].rgb[k]);
      sum += static_cast<double>(d.rgb[k]) - still;
      of += still;
    }
    return sum / of;
  };
  Renderer renderer(f.device, {}, scene);
  const Drawn first = draw(renderer, 0, true);
  Drawn last;
  for (uint32_t i = 1; i <= kFrames; ++i) {
    last = draw(renderer, i, true);
    if (std::getenv("NEPHO_TEST_SHOW"))
      MESSAGE("frame ", i, ": ", psnr(last.shown, mean), " dB, bias ", 100.0 * bias(last), " %, ", last.fresh, " fresh, ", last.refresh);
  }
  MESSAGE("live: first ", psnr(first.shown, mean), " dB, bias ", 100.0 * bias(first), " %, ", first.cells, " cells; after ", kFrames, " frames ",
          psnr(last.shown, mean), " dB, bias ", 100.0 * bias(last), " %; stills ", psnr(stills[0].shown, mean_shown({stills[1]})),
          " dB from each other, ", stills[0].cells, " cells");
  CHECK(psnr(first.shown, mean) > 33.0);
  CHECK(psnr(last.shown, mean) > 34.0);  // of one frame: the noise of its march is in it
  CHECK(std::abs(bias(last)) < 0.04);  // whole steps instead of half ones are in it
}

TEST_CASE("gpu: after a cut light is traced anew, as in a still; sequences are the same each time") {
  GpuFixture f;
  const Scene scene = light_scene({48, 27});
  std::vector<float> before;
  for (int run = 0; run < 2; ++run) {
    Renderer renderer(f.device, {}, scene);
    draw(renderer, 0);
    CameraParams camera = scene.camera;
    camera.heading_deg += 0.5;
    camera.lat_deg += 1e-5;
    renderer.set_camera(camera);
    const Drawn moved = draw(renderer, 1);
    CHECK(moved.fresh < moved.cells / 4);
    if (run == 0) {
      before = moved.rgb;
      // The sun an hour later; and a camera that is elsewhere.
      renderer.set_time(parse_utc(scene.time).plus_seconds(3600.0));
      Drawn cut = draw(renderer, 2);
      CHECK(cut.fresh == cut.cells);
      camera.lat_deg += 0.1;
      renderer.set_camera(camera);
      cut = draw(renderer, 3);
      CHECK(cut.fresh == cut.cells);
    } else {
      CHECK(moved.rgb == before);
    }
  }
}

}  // namespace nepho
