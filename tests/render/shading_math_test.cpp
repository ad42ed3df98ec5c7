#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "common/tonemap.h"
#include "common/water.h"
#include "render/camera_pose.h"
#include "render/frame_setup.h"
#include "render/output_layers.h"
#include "tone/white_balance.h"

using namespace nepho;
using namespace nepho::shared;

TEST_CASE("water: the glint of a gently roughened sea reflects Fresnel's share of the sun over the hemisphere") {
  // Energy: integral of glint * cos_v over all directions = mean Fresnel reflectance of the irradiance E cos_s. Sun at
  // 30 degrees from the zenith, nearly smooth sea: F(30 deg) = 0.0217 (n = 1.34), times cos_s. Midpoint rule, 1 degree
  // cells.
  const float zenith = kPi / 6.0f;
  const vec3 up(0, 0, 1), sun(std::sin(zenith), 0, std::cos(zenith));
  const float slopes = 0.01f;
  double flux = 0.0;
  const int rows = 360, columns = 720;
  for (int i = 0; i < rows; ++i) {
    const double theta = (i + 0.5) / rows * 0.5 * static_cast<double>(kPi);
    for (int j = 0; j < columns; ++j) {
      const double phi = (j + 0.5) / columns * 2.0 * static_cast<double>(kPi);
      const vec3 eye(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      const double solid =
          std::sin(theta) * (0.5 * static_cast<double>(kPi) / rows) * (2.0 * static_cast<double>(kPi) / columns);
      flux += static_cast<double>(sun_glint_per_sr(up, eye, sun, slopes)) * std::cos(theta) * solid;
    }
  }
  const double expected = static_cast<double>(fresnel_water(std::cos(zenith)) * std::cos(zenith));
  CHECK(flux == doctest::Approx(expected).epsilon(0.03));  // slopes spread the angles of incidence by a few degrees
}

TEST_CASE("water: Fresnel reflectance is 2.1 % at normal and 100 % at grazing incidence") {
  CHECK(fresnel_water(1.0f) == doctest::Approx(std::pow(0.34 / 2.34, 2.0)).epsilon(1e-5));
  CHECK(fresnel_water(0.0f) == doctest::Approx(1.0).epsilon(1e-5));
  CHECK(fresnel_water(std::cos(kPi / 3.0f)) == doctest::Approx(0.0603).epsilon(0.01));
}

TEST_CASE("exposure: a grey card in full sun meters at about EV 15, and EV and exposure invert") {
  // 18 % grey under 1e5 lux: 5730 cd/m2; sunny 16 is EV 15.
  const float ev = ev100_from_luminance(0.18f / kPi * 1.0e5f);
  CHECK(ev == doctest::Approx(15.5).epsilon(0.02));
  CHECK(exposure_from_ev100(0.0f) == doctest::Approx(1.0 / 1.2));
}

TEST_CASE("tone curves: black stays black, more light is never darker, and white is reached") {
  for (const uint32_t curve : {kToneLinear, kToneReinhard, kToneAces, kToneAgx}) {
    float last = -1.0f;
    for (float v = 0.0f; v < 40.0f; v = v * 1.2f + 1.0e-3f) {
      const vec3 out = tone_map(vec3(v), curve);
      CHECK(out.g >= last - 1e-4f);
      last = out.g;
    }
    CHECK(tone_map(vec3(0.0f), curve).g < 2e-3f);
    CHECK(last > 0.95f);
  }
}

TEST_CASE("camera: look-at puts the target on the optical axis and keeps the horizon level") {
  CameraParams params;
  params.lat_deg = 35.47;
  params.lon_deg = 138.60;
  params.height_m = 2500.0;
  params.look_at = LookAt{35.3606, 138.7274, 3700.0};
  const CameraPose pose = resolve_camera(params, [](double, double) { return 0.0; });
  const dvec3 target = ecef_from_geodetic(Geodetic::from_degrees(35.3606, 138.7274, 3700.0));
  const dvec3 towards = glm::normalize(target - pose.ecef_m);
  CHECK(glm::dot(towards, pose.axes.forward) > 1.0 - 1e-14);
  CHECK(std::abs(glm::dot(pose.axes.right, geodetic_up_ecef(pose.at.lat_rad, pose.at.lon_rad))) < 1e-12);
}

TEST_CASE("camera: without a height it stands 2 m above the ground") {
  CameraParams params;
  const CameraPose pose = resolve_camera(params, [](double, double) { return 1234.0; });
  CHECK(pose.at.height_m == doctest::Approx(1236.0));
}

TEST_CASE("camera: one in the ground is lifted to 2 m above it, and aimed from there") {
  const auto ground = [](double lat_rad, double) { return lat_rad > 0.0 ? 1234.0 : 30.0; };  // south: the sea
  CameraParams params;
  params.lat_deg = 35.47;
  params.lon_deg = 138.60;
  params.height_m = 1000.0;
  params.look_at = LookAt{35.3606, 138.7274, 3700.0};
  const CameraPose lifted = resolve_camera(params, ground);
  CHECK(lifted.at.height_m == 1236.0);
  REQUIRE(lifted.lifted_from_m.has_value());
  CHECK(*lifted.lifted_from_m == 1000.0);
  const dvec3 target = ecef_from_geodetic(Geodetic::from_degrees(35.3606, 138.7274, 3700.0));
  CHECK(glm::dot(glm::normalize(target - lifted.ecef_m), lifted.axes.forward) > 1.0 - 1e-14);
  CHECK(glm::length(ecef_from_geodetic(lifted.at) - lifted.ecef_m) < 1e-6);

  params.allow_underground = true;
  CHECK(resolve_camera(params, ground).at.height_m == 1000.0);
  CHECK_FALSE(resolve_camera(params, ground).lifted_from_m.has_value());

  CameraParams sea;
  sea.lat_deg = -10.0;
  sea.agl_m = -5.0;
  CHECK(resolve_camera(sea, ground).at.height_m == 32.0);
  for (const double agl_m : {0.1, 0.5, 2.0, 1e6}) {  // just above the ground is above it
    sea.agl_m = agl_m;
    CHECK(resolve_camera(sea, ground).at.height_m == 30.0 + agl_m);
  }
  sea.agl_m = 0.0;  // the near plane would cut the ground open
  CHECK(resolve_camera(sea, ground).at.height_m == 32.0);
  // Cameras above all ground ask nobody.
  sea.agl_m.reset();
  sea.height_m = 9000.0;
  CHECK(resolve_camera(
            sea, [](double, double) -> double { throw 1; }, 8000.0)
            .at.height_m == 9000.0);
}

TEST_CASE("frame constants: the direction of a pixel agrees with the double camera to a hundredth of a pixel") {
  CameraParams params;
  params.height_m = 400e3;
  params.pitch_deg = -40.0;
  params.heading_deg = 123.0;
  params.roll_deg = 10.0;
  const CameraPose pose = resolve_camera(params, [](double, double) { return 0.0; });
  const Extent2D extent{641, 361};
  const FrameConstants c = make_frame_constants(pose, extent, FrameLight{}, 0.0, 0, 0, glm::vec2(0.0f));
  const double tan_y = std::tan(0.5 * pose.fov_rad), tan_x = tan_y * 641.0 / 361.0;
  for (const auto& [px, py] : {std::pair{0, 0}, {640, 360}, {320, 180}, {17, 333}}) {
    const double x = 2.0 * (px + 0.5) / 641.0 - 1.0, y = 1.0 - 2.0 * (py + 0.5) / 361.0;
    const dvec3 expected = glm::normalize(pose.axes.forward + x * tan_x * pose.axes.right + y * tan_y * pose.axes.up);
    const dvec3 found = dvec3(pixel_direction(c, vec2(static_cast<float>(px) + 0.5f, static_cast<float>(py) + 0.5f)));
    CHECK(glm::length(found - expected) < 0.01 * static_cast<double>(c.pixel_angle_rad));
  }
}

TEST_CASE("white balance: 6504 K changes nothing, daylight of the chosen temperature becomes grey") {
  const glm::dmat3 same = rec709_white_balance(6504.0);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) CHECK(same[c][r] == doctest::Approx(c == r ? 1.0 : 0.0).epsilon(1e-9));
  // D55, x 0.33242, y 0.34743 (CIE 15), in linear Rec. 709.
  const glm::dvec3 xyz(0.33242 / 0.34743, 1.0, (1.0 - 0.33242 - 0.34743) / 0.34743);
  const glm::dvec3 d55(3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
                       -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
                       0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z);
  const glm::dvec3 grey = rec709_white_balance(5503.0) * d55;
  CHECK(grey.r == doctest::Approx(grey.g).epsilon(3e-3));
  CHECK(grey.b == doctest::Approx(grey.g).epsilon(3e-3));
}

TEST_CASE("output layers: a channel or a group is written when asked for, R G B always, all without a wish") {
  FrameReadback frame;
  frame.extent = {1, 1};
  frame.radiance = frame.background = frame.albedo = frame.cloud = frame.cloud_info = {1, 2, 3, 1};
  frame.depth_m = {100.0f};
  CameraParams params;
  params.height_m = 10.0;
  const CameraPose pose = resolve_camera(params, [](double, double) { return 0.0; });
  const auto names = [&](const std::set<std::string>& wanted) {
    std::vector<std::string> out;
    for (const ImageChannel& c : make_output_layers(frame, pose, wanted).channels) out.push_back(c.name);
    return out;
  };
  CHECK(names({"position.lat_deg", "cloud.layer"}) ==
        std::vector<std::string>{"R", "G", "B", "position.lat_deg", "cloud.layer"});
  CHECK(names({"depth"}) == std::vector<std::string>{"R", "G", "B", "depth.Z"});
  CHECK(names({}).size() == 3 + 1 + 6 + 4 + 3 + 7);
  for (const std::string& name : names({})) {
    const auto& known = known_layers();
    CHECK((name.size() == 1 || std::find(known.begin(), known.end(), name) != known.end()));
  }
}
