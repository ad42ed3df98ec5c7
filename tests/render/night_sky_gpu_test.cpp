// Stars, moon and airglow as shaders see them: places, fluxes, sides.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "astro/moonlight.h"
#include "gpu/commands.h"
#include "gpu/gpu_fixture.h"
#include "rasters/default_earth.h"
#include "rasters/gdal_opener.h"
#include "render/frame_setup.h"
#include "render/night_sky.h"
#include "render/night_sky_test.comp.h"

using namespace nepho;

namespace {

constexpr double kPi = std::numbers::pi;
const vec3 kSunAt1Au(134e3f, 132e3f, 130e3f);
const char* const kNight = "2026-06-21T12:00:00Z";  // night over Japan

double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

struct View {
  std::string time = kNight;
  Geodetic at = Geodetic::from_degrees(35.0, 138.0, 2.0);
  dvec3 towards{0.0, 0.0, 1.0};  ///< unit, ECEF
  double fov_deg = 10.0;
  Extent2D size{96, 64};
  NightSkyParams params{};
  glm::vec2 jitter{0.0f};
};

CameraPose pose_of(const View& v) {
  CameraPose pose;
  pose.at = v.at;
  pose.ecef_m = ecef_from_geodetic(v.at);
  pose.fov_rad = rad_from_deg(v.fov_deg);
  const dvec3 aside = glm::cross(v.towards, std::abs(v.towards.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(1, 0, 0));
  pose.axes.forward = v.towards;
  pose.axes.right = glm::normalize(aside);
  pose.axes.up = glm::cross(pose.axes.right, v.towards);
  return pose;
}

struct Drawn {
  shared::FrameConstants frame;
  std::vector<float> stars, moon, airglow, light;  ///< four floats a pixel
  std::vector<std::string> passes;
  dvec3 at(const std::vector<float>& image, uint32_t x, uint32_t y) const {
    const float* p = &image[4 * (size_t{y} * frame.size.x + x)];
    return {p[0], p[1], p[2]};
  }
  double solid_angle(uint32_t x, uint32_t y) const {
    return static_cast<double>(shared::pixel_solid_angle_sr(frame, glm::vec2(x, y) + 0.5f));
  }
  /// Illuminance of the whole picture on a plane that faces each pixel.
  dvec3 flux(const std::vector<float>& image, const dvec3& less = dvec3(0.0)) const {
    dvec3 sum(0.0);
    for (uint32_t y = 0; y < frame.size.y; ++y)
      for (uint32_t x = 0; x < frame.size.x; ++x) sum += (at(image, x, y) - less) * solid_angle(x, y);
    return sum;
  }
};

class Fixture : public GpuFixture {
 public:
  Drawn draw(const NightSky& night, const View& v) {
    const SkyBodies sky = sky_bodies_at(parse_utc(v.time));
    FrameGraph graph;
    FrameInfo frame;
    frame.extent = v.size;
    frame.constants =
        make_frame_constants(pose_of(v), v.size, FrameLight::from(sky, kSunAt1Au, v.params.moon), 0.0, 0, 0, v.jitter);
    frame.buffer = graph.constants("frame", frame.constants);
    const NightSky::Refs refs = night.add(graph, frame, v.params, sky);
    const ImageDesc desc{.extent = v.size, .format = Format::rgba32f};
    const ImageRef stars = graph.create("stars_out", desc), moon = graph.create("moon_out", desc),
                   airglow = graph.create("airglow_out", desc), light = graph.create("light_out", desc);
    auto pass = graph.pass("night_sky.test");
    pass.uniform("frame", frame.buffer)
        .write("stars_out", stars)
        .write("moon_out", moon)
        .write("airglow_out", airglow)
        .write("light_out", light);
    NightSky::bind(pass, refs);
    pass.record([this, v](gpu::Commands& cmd) { cmd.bind(probe_).dispatch_threads(v.size.width, v.size.height); });
    for (const ImageRef image : {stars, moon, airglow, light}) graph.keep(image);
    executor.run(graph);
    Drawn d{frame.constants,
            executor.read<float>(stars),
            executor.read<float>(moon),
            executor.read<float>(airglow),
            executor.read<float>(light),
            {}};
    for (const gpu::PassTiming& t : executor.timings()) d.passes.push_back(t.name);
    return d;
  }

 private:
  gpu::ComputePipeline probe_{device, {.name = "night_sky.test", .spirv = night_sky_test_comp}};
};

Star star_towards(const dvec3& dir_ecef, double magnitude, const std::string& time = kNight) {
  return {.dir_icrs = glm::transpose(sky_bodies_at(parse_utc(time)).ecef_from_icrs) * dir_ecef,
          .magnitude = magnitude,
          .color = vec3(1.1f, 1.0f, 0.705f)};
}

dvec3 up_at(const Geodetic& at) { return geodetic_up_ecef(at.lat_rad, at.lon_rad); }

View moon_view(const std::string& time, double radii, Extent2D size) {
  View v{.time = time, .size = size};
  const SkyBodies sky = sky_bodies_at(parse_utc(time));
  // Under the moon, so that it is far from any horizon.
  const dvec3 m = sky.moon.dir_ecef;
  v.at = Geodetic::from_degrees(deg_from_rad(std::asin(m.z)), deg_from_rad(std::atan2(m.y, m.x)), 2.0);
  const dvec3 to_moon = m * sky.moon.distance_m - ecef_from_geodetic(v.at);
  v.towards = glm::normalize(to_moon);
  v.fov_deg = deg_from_rad(2.0 * std::atan(radii * kMoonRadius_m / glm::length(to_moon)));
  return v;
}

/// What the disc must give: sunlight by Allen's ratio, and earthshine.
dvec3 expected_moonlight(const Drawn& d, const std::string& time) {
  const SkyBodies sky = sky_bodies_at(parse_utc(time));
  const double radius = static_cast<double>(d.frame.moon_angular_radius_rad);
  const dvec3 earthshine =
      earthshine_illuminance_ratio(sky.moon.phase_angle_rad, sky.moon.distance_m, sky.sun.distance_au) *
      earthshine_color() * dvec3(kSunAt1Au);
  return dvec3(d.frame.moon_share) * dvec3(kSunAt1Au) + earthshine * 0.12 * radius * radius;
}

}  // namespace

TEST_CASE("gpu: a star keeps its illuminance and colour, and its centroid is its direction, all over a wide picture") {
  Fixture gpu;
  View v{.fov_deg = 70.0, .params = {.moon = false}};
  const CameraPose pose = pose_of(v);
  const double tan_y = std::tan(0.5 * pose.fov_rad), tan_x = tan_y * v.size.width / v.size.height;
  for (const glm::dvec2 place : {glm::dvec2(48.0, 32.0), glm::dvec2(48.31, 32.77), glm::dvec2(5.25, 60.02),
                                 glm::dvec2(90.999, 3.5), glm::dvec2(70.5, 20.499)}) {
    v.jitter = place.x > 80.0 ? glm::vec2(0.3f, -0.2f) : glm::vec2(0.0f);
    const double x = 2.0 * (place.x + static_cast<double>(v.jitter.x)) / v.size.width - 1.0;
    const double y = 1.0 - 2.0 * (place.y + static_cast<double>(v.jitter.y)) / v.size.height;
    const dvec3 dir = glm::normalize(pose.axes.forward + x * tan_x * pose.axes.right + y * tan_y * pose.axes.up);
    for (const double magnitude : {-1.46, 2.0, 8.0}) {
      const NightSky night(gpu.device, {.moon_texture = nullptr, .stars = {star_towards(dir, magnitude)}});
      const Drawn d = gpu.draw(night, v);
      CAPTURE(magnitude);
      CAPTURE(place.x);
      const dvec3 flux = d.flux(d.stars, dvec3(static_cast<double>(shared::kStarlightLuminance_cd_m2)));
      // The even starlight is subtracted in floats of the sum: 1e-7 of it over the picture, 1 % of a star of V = 8.
      CHECK(luminance(flux) / star_illuminance_lux(magnitude) ==
            doctest::Approx(1.0).epsilon(magnitude > 5 ? 0.02 : 0.002));
      CHECK(flux.x / flux.z == doctest::Approx(1.1 / 0.705).epsilon(magnitude > 5 ? 0.05 : 0.002));
      double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
      for (uint32_t py = 0; py < v.size.height; ++py)
        for (uint32_t px = 0; px < v.size.width; ++px) {
          const double w = (d.at(d.stars, px, py).y - static_cast<double>(shared::kStarlightLuminance_cd_m2)) *
                           d.solid_angle(px, py);
          sum += w;
          sum_x += w * (px + 0.5);
          sum_y += w * (py + 0.5);
        }
      if (magnitude < 5.0) {
        CHECK(std::abs(sum_x / sum - place.x) < 0.02);
        CHECK(std::abs(sum_y / sum - place.y) < 0.02);
      }
    }
  }
}

TEST_CASE(
    "gpu: the sum of all stars fits a pixel, two runs give the same bits, and the pole star stands over the pole") {
  const std::string file = find_default_earth().stars;
  if (file.empty()) {
    MESSAGE("skipped: the package marble-qt-data is not installed");
    return;
  }
  Fixture gpu;
  const std::vector<Star> stars = read_star_catalog(file);
  const NightSky night(gpu.device, {.moon_texture = nullptr, .stars = stars});
  View all{.fov_deg = 175.0, .size = {3, 3}, .params = {.moon = false}};
  const Drawn one = gpu.draw(night, all);
  double expected = 0.0;
  const dmat3 ecef_from_icrs = sky_bodies_at(parse_utc(all.time)).ecef_from_icrs;
  for (const Star& s : stars) {
    glm::vec2 place(0.0f);
    if (!shared::pixel_from_direction(one.frame, vec3(ecef_from_icrs * s.dir_icrs), place)) continue;
    const glm::vec2 cell = glm::floor(place);
    const glm::ivec2 offset = glm::ivec2(1) - glm::ivec2(cell);
    if (std::max(std::abs(offset.x), std::abs(offset.y)) > shared::kStarReach_px) continue;
    const double weight = static_cast<double>(shared::star_weight(offset.x, place.x - cell.x - 0.5f) *
                                              shared::star_weight(offset.y, place.y - cell.y - 0.5f));
    expected += weight * star_illuminance_lux(s.magnitude);
  }
  const double middle = (luminance(one.at(one.stars, 1, 1)) - static_cast<double>(shared::kStarlightLuminance_cd_m2)) *
                        one.solid_angle(1, 1);
  CHECK(expected > 30e-6);  // a good part of the sky's brightest
  CHECK(middle == doctest::Approx(expected).epsilon(0.002));

  View v{.fov_deg = 20.0, .size = {160, 120}, .params = {.moon = false}};  // towards the celestial pole: ECEF z, nearly
  const Drawn first = gpu.draw(night, v), second = gpu.draw(night, v);
  CHECK(first.stars == second.stars);
  uint32_t best_x = 0, best_y = 0;
  for (uint32_t y = 0; y < 120; ++y)
    for (uint32_t x = 0; x < 160; ++x)
      if (first.at(first.stars, x, y).y > first.at(first.stars, best_x, best_y).y) best_x = x, best_y = y;
  // 0.63 degrees from the pole in 2026 (J2000: 0.74), a sixth of a degree a pixel.
  CHECK(std::hypot(best_x + 0.5 - 80.0, best_y + 0.5 - 60.0) == doctest::Approx(0.626 * 6.0).epsilon(0.25));
}

TEST_CASE("gpu: no stars are drawn by day or when not asked for, but from space by day they are") {
  Fixture gpu;
  const dvec3 up = up_at(View{}.at);
  const NightSky night(gpu.device, {.moon_texture = nullptr,
                                    .stars = {star_towards(up, 0.0), star_towards(up, 0.0, "2026-06-21T03:00:00Z")}});
  View v{.towards = up};
  const auto splats = [](const Drawn& d) { return std::count(d.passes.begin(), d.passes.end(), "stars.splat"); };
  CHECK(splats(gpu.draw(night, v)) == 1);
  v.params.stars = false;
  const Drawn without = gpu.draw(night, v);
  CHECK(splats(without) == 0);
  CHECK(luminance(without.flux(without.stars)) == 0.0);
  v.params.stars = true;
  v.time = "2026-06-21T03:00:00Z";  // noon
  const Drawn noon = gpu.draw(night, v);
  CHECK(splats(noon) == 0);
  CHECK(luminance(noon.flux(noon.stars)) == 0.0);
  v.at.height_m = 400e3;
  const Drawn space = gpu.draw(night, v);
  CHECK(splats(space) == 1);
  CHECK(luminance(space.flux(space.stars)) > star_illuminance_lux(0.0));
}

TEST_CASE("gpu: the moon's disc gives Allen's illuminance at every phase, large, small and below a pixel") {
  Fixture gpu;
  const std::string file = find_default_earth().moon;
  SkySources sources;
  if (file.empty()) {
    MESSAGE("with an even moon: the package marble-qt-data is not installed");
  } else {
    sources.moon_texture = make_gdal_opener()->open_imagery(file);
  }
  const NightSky night(gpu.device, sources);
  struct Case {
    const char* time;
    double radii;  ///< half the picture's height in radii of the moon
    double tolerance;
  };
  // Full 2026-01-03 10:03, last quarter 01-10, new 01-18, first quarter 01-26 UTC.
  for (const Case& c : {Case{"2026-01-03T10:00:00Z", 1.3, 0.02}, Case{"2026-01-07T00:00:00Z", 1.3, 0.02},
                        Case{"2026-01-10T16:00:00Z", 1.3, 0.02}, Case{"2026-01-14T12:00:00Z", 1.3, 0.03},
                        Case{"2026-01-26T05:00:00Z", 1.3, 0.02}, Case{"2026-01-03T10:00:00Z", 12.0, 0.02},
                        Case{"2026-01-26T05:00:00Z", 31.0, 0.03}, Case{"2026-01-26T05:00:00Z", 90.0, 0.03},
                        Case{"2026-01-26T05:00:00Z", 200.0, 0.03}}) {
    View v = moon_view(c.time, c.radii, {128, 128});
    v.towards = glm::normalize(v.towards + 0.13 * rad_from_deg(v.fov_deg / 128.0) * pose_of(v).axes.right);
    const Drawn d = gpu.draw(night, v);
    CAPTURE(std::string(c.time));
    CAPTURE(c.radii);
    const dvec3 expected = expected_moonlight(d, c.time), flux = d.flux(d.moon);
    CHECK(luminance(flux) / luminance(expected) == doctest::Approx(1.0).epsilon(c.tolerance));
    CHECK(flux.x / flux.z == doctest::Approx(expected.x / expected.z).epsilon(0.01));
    CHECK(std::all_of(d.moon.begin(), d.moon.end(), [](float l) { return std::isfinite(l) && l >= 0.0f; }));
  }
  // A day from new moon: less than a pixel of it is lit, and what a pixel's centre meets is a matter of luck.
  const Drawn thin = gpu.draw(night, moon_view("2026-01-18T20:00:00Z", 1.3, {128, 128}));
  const double thin_ratio =
      luminance(thin.flux(thin.moon)) / luminance(expected_moonlight(thin, "2026-01-18T20:00:00Z"));
  CHECK(thin_ratio > 0.7);
  CHECK(thin_ratio < 1.4);
}

TEST_CASE("gpu: the moon's lit limb points to the sun; earthshine keeps the other half from being black") {
  Fixture gpu;
  const NightSky night(gpu.device, {});
  const std::string time = "2026-01-23T12:00:00Z";  // a waxing crescent
  View v = moon_view(time, 1.3, {128, 128});
  const Drawn d = gpu.draw(night, v);
  const CameraPose pose = pose_of(v);
  const SkyBodies sky = sky_bodies_at(parse_utc(time));
  glm::dvec2 centroid(0.0);
  double sum = 0.0, least = 1e9;
  for (uint32_t y = 0; y < 128; ++y)
    for (uint32_t x = 0; x < 128; ++x) {
      const double l = luminance(d.at(d.moon, x, y));
      centroid += l * glm::dvec2(x - 63.5, 63.5 - y);
      sum += l;
      if (std::hypot(x - 63.5, y - 63.5) < 0.9 * 64 / 1.3) least = std::min(least, l);
    }
  const glm::dvec2 sun(glm::dot(sky.moon.sun_from_moon_ecef, pose.axes.right),
                       glm::dot(sky.moon.sun_from_moon_ecef, pose.axes.up));
  CHECK(glm::dot(glm::normalize(centroid), glm::normalize(sun)) > 0.995);
  CHECK(glm::length(centroid / sum) > 0.5 * 64 / 1.3);
  // 4.6 days old: near 9 lux of earthshine on albedo 0.12.
  CHECK(least > 0.1);
  CHECK(least < 0.6);
}

TEST_CASE("gpu: Mare Crisium is dark on the moon's east, Imbrium on its north-west, Tycho bright in the south") {
  const std::string file = find_default_earth().moon;
  if (file.empty()) {
    MESSAGE("skipped: the package marble-qt-data is not installed");
    return;
  }
  const MoonMap map = read_moon_map(*make_gdal_opener()->open_imagery(file), 2048);
  const auto mean = [&](double lat, double lon, double r) {
    double sum = 0.0;
    int count = 0;
    for (double a = -r; a <= r; a += 0.25)
      for (double o = -r; o <= r; o += 0.25, ++count)
        sum += static_cast<double>(map.at(rad_from_deg(lat + a), rad_from_deg(lon + o)));
    return sum / count;
  };
  CHECK(mean(33, -16, 4) < 0.08);
  CHECK(mean(17, 59, 3) < 0.08);
  CHECK(mean(17, -59, 3) < 0.08);  // Oceanus Procellarum: dark as well, but
  CHECK(mean(17, 75, 2) > 0.10);   // Crisium is an island: highlands on both sides
  CHECK(mean(17, 45, 2) > 0.085);
  CHECK(mean(-43.3, -11.3, 1) > 0.16);
  CHECK(mean(-30, 10, 5) > 0.11);
  CHECK(*std::min_element(map.albedo.begin(), map.albedo.end()) > 0.04f);  // no gap is left

  Fixture gpu;
  SkySources sources;
  sources.moon_texture = make_gdal_opener()->open_imagery(file);
  const NightSky night(gpu.device, sources);
  const std::string time = "2026-01-03T10:00:00Z";  // full
  View v = moon_view(time, 1.1, {256, 256});
  const Drawn d = gpu.draw(night, v);
  const CameraPose pose = pose_of(v);
  const SkyBodies sky = sky_bodies_at(parse_utc(time));
  // Where a place on the moon is drawn, worked out forwards in double.
  const auto seen = [&](double lat, double lon) {
    const double la = rad_from_deg(lat), lo = rad_from_deg(lon);
    const dvec3 body(std::cos(la) * std::cos(lo), std::cos(la) * std::sin(lo), std::sin(la));
    const dvec3 point = sky.moon.dir_ecef * sky.moon.distance_m +
                        kMoonRadius_m * (glm::transpose(sky.moon.body_from_ecef) * body) - pose.ecef_m;
    const double t = std::tan(0.5 * pose.fov_rad) * glm::dot(point, pose.axes.forward);
    const glm::dvec2 p(128.0 + 128.0 * glm::dot(point, pose.axes.right) / t,
                       128.0 - 128.0 * glm::dot(point, pose.axes.up) / t);
    double sum = 0.0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i)
        sum += luminance(d.at(d.moon, static_cast<uint32_t>(p.x + i), static_cast<uint32_t>(p.y + j))) / 9.0;
    return std::pair(p, sum);
  };
  const auto [crisium, crisium_cd] = seen(17.0, 59.0);
  const auto [tycho, tycho_cd] = seen(-43.3, -11.3);
  const auto [imbrium, imbrium_cd] = seen(33.0, -16.0);
  const auto [highlands, highlands_cd] = seen(-30.0, 10.0);
  CHECK(crisium_cd < 0.7 * highlands_cd);
  CHECK(imbrium_cd < 0.7 * highlands_cd);
  CHECK(tycho_cd > 1.15 * highlands_cd);
  // Its east is the sky's west: with celestial north up, right.
  const dvec3 north = glm::normalize(dvec3(0, 0, 1) - v.towards * v.towards.z), west = glm::cross(v.towards, north);
  const glm::dvec2 north_px(glm::dot(north, pose.axes.right), -glm::dot(north, pose.axes.up)),
      west_px(glm::dot(west, pose.axes.right), -glm::dot(west, pose.axes.up));
  CHECK(glm::dot(crisium - glm::dvec2(128.0), west_px) > 60.0);
  CHECK(glm::dot(tycho - glm::dvec2(128.0), north_px) < -50.0);
}

TEST_CASE("gpu: airglow grows towards the horizon by van Rhijn's law and is a thin bright layer from orbit") {
  Fixture gpu;
  const NightSky night(gpu.device, {});
  View v{
      .at = Geodetic::from_degrees(0.0, 138.0, 0.0), .fov_deg = 2.0, .size = {9, 9}, .params = {.airglow_cd_m2 = 1e-4}};
  const dvec3 up = up_at(v.at), east(-std::sin(v.at.lon_rad), std::cos(v.at.lon_rad), 0.0);
  const double a = 6378137.0, r1 = a + 85e3, r2 = a + 97e3;
  for (const double zenith_deg : {0.0, 45.0, 75.0, 88.0}) {
    v.towards = std::cos(rad_from_deg(zenith_deg)) * up + std::sin(rad_from_deg(zenith_deg)) * east;
    const Drawn d = gpu.draw(night, v);
    const double s = a * std::sin(rad_from_deg(zenith_deg));
    const double path = (std::sqrt(r2 * r2 - s * s) - std::sqrt(r1 * r1 - s * s)) / 12e3;
    CAPTURE(zenith_deg);
    CHECK(luminance(d.at(d.airglow, 4, 4)) == doctest::Approx(1e-4 * path).epsilon(0.002));
    CHECK(d.airglow[4 * 40 + 3] == 0.0f);  // all of it is behind the air
  }
  CHECK(std::abs(luminance(dvec3(shared::airglow_color())) - 1.0) < 0.002);

  // Over the equator at 400 km, along the meridian of scaled space's circle: towards the limb at 90 km.
  v.at.height_m = 400e3;
  const double r = a + 400e3;
  const auto towards_limb = [&](double height_m) {
    const double sine = (a + height_m) / r;
    return sine * east - std::sqrt(1.0 - sine * sine) * up;
  };
  v.fov_deg = 0.05;
  v.towards = towards_limb(90e3);
  const Drawn limb = gpu.draw(night, v);
  const double p2 = (a + 90e3) * (a + 90e3);
  CHECK(luminance(limb.at(limb.airglow, 4, 4)) ==
        doctest::Approx(1e-4 * 2.0 * std::sqrt(r2 * r2 - p2) / 12e3).epsilon(0.02));
  CHECK(static_cast<double>(limb.airglow[4 * 40 + 3]) ==
        doctest::Approx(0.5 * limb.at(limb.airglow, 4, 4).y).epsilon(0.01));  // half of it is this side of the limb
  v.towards = towards_limb(100e3);
  const Drawn above = gpu.draw(night, v);
  CHECK(luminance(above.at(above.airglow, 4, 4)) == 0.0);
  v.towards = -up;
  const Drawn below = gpu.draw(night, v);
  CHECK(luminance(below.at(below.airglow, 4, 4)) == doctest::Approx(1e-4).epsilon(0.002));  // the near sheet alone
  CHECK(static_cast<double>(below.airglow[4 * 40 + 3]) ==
        doctest::Approx(below.at(below.airglow, 4, 4).y).epsilon(0.002));
}

TEST_CASE("gpu: night light on the ground is about 1e-3 lux and never 0 with airglow or stars") {
  Fixture gpu;
  const NightSky night(gpu.device, {});
  const Drawn d = gpu.draw(night, {});
  CHECK(luminance(d.at(d.light, 0, 0)) > 5e-4);
  CHECK(luminance(d.at(d.light, 0, 0)) < 2e-3);
}
