#include "clouds/shadow_test_tools.h"

namespace nepho {
namespace {
using namespace test;

/// What check_accuracy() looks at.
struct Accuracy {
  Errors ground, inside;
};

Accuracy measure(ShadowRig& rig, const ShadowView& view, size_t count) {
  const float reach = rig.maps.data().at[rig.maps.data().cascades - 1].fade_m;
  constexpr float kTrueStep_m = 3.0f;
  Accuracy a;
  a.ground = errors_of(rig.ask(view, ground_points(view, count, reach), kTrueStep_m));
  a.inside = errors_of(rig.ask(view, cloud_points(rig, view, count, reach), kTrueStep_m));
  return a;
}

void check_accuracy(const Accuracy& a, size_t count, const std::string& what) {
  MESSAGE(what << ": ground " << a.ground.count << " points, mean |d| " << a.ground.mean_abs << ", bias "
               << a.ground.bias << ", true mean " << a.ground.mean_truth << "; inside " << a.inside.count
               << " points, mean |d| " << a.inside.mean_abs << ", bias " << a.inside.bias << ", true mean "
               << a.inside.mean_truth);
  CHECK(a.ground.count == count);
  CHECK(a.inside.count == count);
  // Of 300 points the mean of errors with a spread of 0.09 is known to 0.005: twice that is added to the bounds.
  const double unsure = full_size() ? 0.0 : 0.01;
  CHECK(a.ground.mean_abs <= 0.03 + unsure);
  CHECK(a.inside.mean_abs <= 0.06 + unsure);
  CHECK(std::abs(a.ground.bias) <= 0.015 + unsure);
  CHECK(std::abs(a.inside.bias) <= 0.015 + unsure);
}

TEST_CASE("gpu: shadow maps are within 0.03 of a fine march on the ground, within 0.06 inside clouds, bias 0.015") {
  GpuFixture gpu;
  const size_t count = full_size() ? 10000 : 300;
  CloudShadowParams shadows;
  shadows.slices = 4;
  ShadowRig rig(gpu, cumulus(), shadows);
  for (const double elevation : full_size() ? std::vector<double>{60.0, 30.0, 10.0} : std::vector<double>{60.0}) {
    ShadowView view;
    view.sun_elevation_deg = elevation;
    rig.update(view);
    check_accuracy(measure(rig, view, count), count, fmt::format("sun {} deg", elevation));
  }
  // The mean of several marches of the same maps is no worse.
  ShadowView view;
  for (int i = 0; i < 20; ++i) rig.update(view);
  CHECK(rig.maps.work().marched == 0);
  check_accuracy(measure(rig, view, count), count, "sun 60 deg, resolved");
}

TEST_CASE("gpu: a shadow's edge on the ground is within a texel of the true one") {
  GpuFixture gpu;
  ShadowRig rig(gpu, cumulus());
  const ShadowView view;
  rig.update(view);
  const shared::ShadowMaps& d = rig.maps.data();
  const FrameInfo frame = frame_of(view);
  // Lines across the ground in the first cascade, points a quarter of a texel apart.
  const float texel = d.at[0].texel_m;
  constexpr int kHalf = 24;
  const std::vector<glm::vec3> middles = ground_points(view, full_size() ? 4000 : 500, d.at[0].fade_m);
  std::vector<glm::vec3> points;
  for (const glm::vec3& middle : middles) {
    const glm::vec3 up = shared::geodetic_up(frame.constants.planet, middle);
    const glm::vec3 along = normalize(cross(up, glm::vec3(0.3f, -0.5f, 0.8f)));  // across the light, nearly
    for (int i = -kHalf; i <= kHalf; ++i) points.push_back(middle + along * (0.25f * texel * static_cast<float>(i)));
  }
  const std::vector<ShadowAnswer> answers = rig.ask(view, points, 3.0f);
  // Where the light first passes half, between two points.
  const auto crossing = [&](size_t line, bool truth) -> std::optional<double> {
    const size_t first = line * (2 * kHalf + 1);
    const auto value = [&](int i) {
      const ShadowAnswer& a = answers[first + static_cast<size_t>(i)];
      return static_cast<double>(truth ? a.truth : a.by_map);
    };
    std::optional<double> at;
    for (int i = 0; i < 2 * kHalf; ++i) {
      if ((value(i) - 0.5) * (value(i + 1) - 0.5) >= 0.0) continue;
      if (at) return std::nullopt;  // more than one edge
      at = 0.25 * (i + (0.5 - value(i)) / (value(i + 1) - value(i)));
    }
    return at;
  };
  std::vector<double> off;
  for (size_t line = 0; line < middles.size(); ++line) {
    const auto truth = crossing(line, true), map = crossing(line, false);
    if (truth && map) off.push_back(std::abs(*map - *truth));
  }
  REQUIRE(off.size() > 15);
  std::sort(off.begin(), off.end());
  MESSAGE(off.size() << " edges: median " << off[off.size() / 2] << " texels off, 90 % within "
                     << off[off.size() * 9 / 10] << ", the worst " << off.back());
  CHECK(off[off.size() / 2] < 0.5);
  CHECK(off[off.size() * 9 / 10] < 1.0);
}

TEST_CASE("gpu: a camera that moves by a metre keeps its maps and the light on the ground") {
  GpuFixture gpu;
  CloudShadowParams shadows;
  shadows.rounds = 1;  // what is seen is the camera's doing alone
  ShadowRig rig(gpu, cumulus(), shadows);
  ShadowView before;
  rig.update(before);
  const shared::ShadowMaps first = rig.maps.data();
  const std::vector<glm::vec3> points = ground_points(before, 400, first.at[2].reach_m);
  const std::vector<ShadowAnswer> seen = rig.ask(before, points, 0.0f);
  ShadowView after = before;
  after.east_m = 0.8;
  after.north_m = 0.6;
  for (const bool anew : {false, true}) {  // kept maps, and maps made from the new place
    if (anew) rig.maps.reset();
    rig.update(after);
    const glm::vec3 moved(frame_of(after).camera_ecef_m - frame_of(before).camera_ecef_m);
    std::vector<glm::vec3> same;
    for (const glm::vec3& p : points) same.push_back(p - moved);
    const std::vector<ShadowAnswer> now = rig.ask(after, same, 0.0f);
    double change = 0.0, sum = 0.0;
    for (size_t i = 0; i < points.size(); ++i) {
      change += static_cast<double>(std::abs(now[i].by_map - seen[i].by_map));
      sum += static_cast<double>(seen[i].by_map);
    }
    INFO(anew);
    CHECK(change < 0.005 * sum);
  }
}

/// A texel's corner from the Earth's centre in units of texels of its grid, along the plane's axes.
glm::dvec2 grid_place(const shared::ShadowMaps& d, uint32_t k, const FrameInfo& frame, const LightAxes& axes) {
  const glm::dvec3 corner = frame.camera_ecef_m + glm::dvec3(d.at[k].corner);
  return glm::dvec2(dot(corner, axes.x), dot(corner, axes.y)) / static_cast<double>(d.at[k].texel_m);
}

TEST_CASE("gpu: windows move by whole texels, and what stays in view keeps its bits") {
  GpuFixture gpu;
  ShadowRig rig(gpu, cumulus());
  ShadowView view;
  rig.update(view);
  const shared::ShadowMaps first = rig.maps.data();
  const LightAxes axes = LightAxes::towards(glm::dvec3(first.light));
  const FrameInfo start = frame_of(view);
  const std::vector<std::byte> bits = gpu.device.download(rig.maps.image());
  const uint32_t all = rig.maps.work().marched;
  view.east_m = 237.0;
  view.north_m = -411.0;
  view.heading_deg = 1.0;
  // One round only: what is there already is not refined.
  rig.update(view);
  CHECK(rig.maps.work().marched < all / 2);
  const FrameInfo end = frame_of(view);
  for (uint32_t k = 0; k < first.cascades; ++k) {
    const shared::ShadowCascade &was = first.at[k], &is = rig.maps.data().at[k];
    CHECK(was.texel_m == is.texel_m);
    const glm::dvec2 shift = grid_place(rig.maps.data(), k, end, axes) - grid_place(first, k, start, axes);
    // Whole tiles, but for corners in single precision: 1e-7 of the way from the camera.
    const glm::dvec2 off = shift - round(shift / 8.0) * 8.0;
    CHECK(std::abs(off.x) < 2e-3);
    CHECK(std::abs(off.y) < 2e-3);
    // The storage place goes with the window.
    const glm::ivec2 steps(static_cast<int>(std::lround(shift.x)), static_cast<int>(std::lround(shift.y)));
    const int n = static_cast<int>(first.resolution);
    CHECK(static_cast<int>(is.first.x) == ((static_cast<int>(was.first.x) + steps.x) % n + n) % n);
    CHECK(static_cast<int>(is.first.y) == ((static_cast<int>(was.first.y) + steps.y) % n + n) % n);
  }
  CHECK(gpu.device.download(rig.maps.image()) != bits);
}

TEST_CASE("gpu: where nothing changes nothing is marched, and no bit changes; time makes maps anew, in slices") {
  GpuFixture gpu;
  CloudParams params = cumulus();
  params.layers[0].wind_east_mps = 10.0;
  CloudShadowParams shadows;
  shadows.rounds = 2;
  shadows.slices = 3;
  shadows.resolution = 128;
  ShadowRig rig(gpu, params, shadows);
  ShadowView view;
  rig.update(view);
  const uint32_t needed = rig.maps.work().needed;
  REQUIRE(needed > 100);
  CHECK(rig.maps.work().marched == needed);
  CHECK(rig.passes("clouds.shadow") == 1);
  uint32_t more = 0;
  for (int i = 0; i < 3; ++i) {
    rig.update(view);
    CHECK(rig.maps.work().marched <= needed / 3 + 1);
    more += rig.maps.work().marched;
  }
  CHECK(more == needed);
  const std::vector<std::byte> bits = gpu.device.download(rig.maps.image());
  for (int i = 0; i < 3; ++i) {
    rig.update(view);
    CHECK(rig.maps.work().marched == 0);
    CHECK(rig.passes("clouds.shadow") == 0);
  }
  CHECK(gpu.device.download(rig.maps.image()) == bits);
  view.time_s += 0.01;  // a tenth of a metre of wind: nobody sees it
  rig.update(view);
  CHECK(rig.maps.work().marched == 0);
  CHECK(gpu.device.download(rig.maps.image()) == bits);
  // A fifth of a texel of the nearest maps: a share of them.
  view.time_s += 0.2 * static_cast<double>(rig.maps.data().at[0].texel_m) / 11.0;
  rig.update(view);
  CHECK(rig.maps.work().marched > 0);
  CHECK(rig.maps.work().marched <= (needed + 2) / 3);
  view.time_s += 600.0;  // they are all wrong
  rig.update(view);
  CHECK(rig.maps.work().marched == needed);
  view.sun_elevation_deg += 1.0;
  rig.update(view);
  CHECK(rig.maps.work().marched == rig.maps.work().needed);
}

TEST_CASE("gpu: no maps where they are turned off, nothing casts, or the layer is a slab") {
  GpuFixture gpu;
  const ShadowView view;
  for (int which = 0; which < 3; ++which) {
    CloudParams params = cumulus();
    CloudShadowParams shadows;
    if (which == 0) shadows.enabled = false;
    if (which == 1) params.layers[0].casts_shadow = false;
    if (which == 2) params.uniform_density = 0.1;
    ShadowRig rig(gpu, params, shadows);
    for (const ShadowAnswer& a : rig.ask(view, ground_points(view, 64, 20e3f), 0.0f)) CHECK(a.by_map == 1.0f);
    CHECK(rig.maps.work().needed == 0);
  }
}

}  // namespace
}  // namespace nepho
