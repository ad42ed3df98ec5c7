// The slab that `nepho probe slab` evaluates, drawn as a user would draw it: data/scenes/slab.json.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "astro/sky_bodies.h"
#include "atmosphere/luminance.h"
#include "base/files.h"
#include "clouds/slab_probe.h"
#include "geo/frames.h"
#include "gpu/gpu_fixture.h"
#include "render/renderer.h"
#include "scene/scene_json.h"

using namespace nepho;

namespace {

struct DrawnSlab {
  Slab slab;
  RenderResult result;
  dvec3 sun_lux;  ///< on a facing plane
  dvec3 sun_dir;  ///< towards it
  dvec3 up;
  const std::vector<float>& channel(const std::string& name) const { return result.layers.find(name)->values; }
  /// Of a pixel, the way the light travels.
  dvec3 travel(uint32_t x, uint32_t y) const {
    const ImageBuffer& image = result.layers;
    const double tangent = std::tan(0.5 * result.pose.fov_rad);
    const CameraAxes& axes = result.pose.axes;
    return -glm::normalize(axes.forward +
                           (2.0 * (x + 0.5) / image.width - 1.0) * tangent * image.width / image.height * axes.right +
                           (1.0 - 2.0 * (y + 0.5) / image.height) * tangent * axes.up);
  }
  /// Radiance per irradiance of a plane that faces the sun, 1/sr.
  double radiance(size_t pixel) const { return static_cast<double>(channel("cloud.G")[pixel]) / sun_lux.g; }
  /// At the pixel that sees the light of a direction best.
  double radiance(const SlabDirection& direction) const {
    const dvec3 flat = glm::normalize(-sun_dir + glm::dot(sun_dir, up) * up), aside = glm::cross(up, flat);
    const double phi = rad_from_deg(direction.phi_deg), sine = std::sqrt(1.0 - direction.mu * direction.mu);
    const dvec3 wanted =
        sine * (std::cos(phi) * flat + std::sin(phi) * aside) + (direction.up ? 1.0 : -1.0) * direction.mu * up;
    double best = -1.0, found = 0.0;
    for (uint32_t y = 0; y < result.layers.height; ++y)
      for (uint32_t x = 0; x < result.layers.width; ++x)
        if (const double cosine = glm::dot(travel(x, y), wanted); cosine > best) {
          best = cosine;
          found = radiance(size_t{y} * result.layers.width + x);
        }
    return found;
  }
  /// Flux through a horizontal plane per flux of the sun.
  double flux() const {
    const ImageBuffer& image = result.layers;
    const double tangent = std::tan(0.5 * result.pose.fov_rad), pixel = 2.0 * tangent / image.height;
    double sum = 0.0;
    for (uint32_t y = 0; y < image.height; ++y)
      for (uint32_t x = 0; x < image.width; ++x) {
        const double mu = std::abs(glm::dot(travel(x, y), up));  // the camera looks straight up or down
        sum += radiance(size_t{y} * image.width + x) * pixel * pixel * mu * mu * mu * mu;
      }
    return sum / slab.mu0;
  }
};

DrawnSlab draw(gpu::Device& device, double height_m, double pitch_deg) {
  Scene scene = load_scene(data_dir() / "scenes" / "slab.json");
  scene.camera.height_m = height_m;
  scene.camera.pitch_deg = pitch_deg;
  scene.clouds.multiple_scattering = "octaves";  // the same every time
  DrawnSlab drawn;
  const CloudParams& clouds = scene.clouds;
  const double extinction_per_m = clouds.scattering_per_m + clouds.absorption_per_m;
  const SunState sun = sky_bodies_at(parse_utc(scene.time)).sun;
  drawn.sun_lux = dvec3(sun_illuminance_at_1au(scene.atmosphere)) / (sun.distance_au * sun.distance_au);
  drawn.sun_dir = sun.dir_ecef;
  drawn.up = geodetic_up_ecef(rad_from_deg(scene.camera.lat_deg), rad_from_deg(scene.camera.lon_deg));
  drawn.slab = {.tau = extinction_per_m * clouds.layers.at(0).thickness_m,
                .single_scattering_albedo = clouds.scattering_per_m / extinction_per_m,
                .g = clouds.phase_g_forward,
                .mu0 = glm::dot(drawn.sun_dir, drawn.up)};
  Renderer renderer(device, {.bare_albedo = scene.imagery.bare_albedo}, scene);
  drawn.result = renderer.render({.display = false});
  return drawn;
}

}  // namespace

TEST_CASE(
    "gpu: the slab scene, drawn, has the probe's reflectance within 2 % and its radiances within 15 %, and nothing "
    "else "
    "is in the picture") {
  GpuFixture f;
  const DrawnSlab above = draw(f.device, 770.0, -90.0), below = draw(f.device, 480.0, 90.0);
  CHECK(above.slab.mu0 == doctest::Approx(0.5).epsilon(1e-4));
  const SlabLight probe = MarchedSlabs(f.device, "octaves").solve({&above.slab, 1}).front();
  // The picture ends 5 degrees above the horizon, where mu^2 = 0.76 % of a hemisphere's even light would come from.
  MESSAGE("reflectance ", above.flux(), " and ", probe.reflectance, ", diffuse transmittance ", below.flux(), " and ",
          probe.transmittance_diffuse);
  CHECK(above.flux() == doctest::Approx(probe.reflectance).epsilon(0.02));
  CHECK(below.flux() == doctest::Approx(probe.transmittance_diffuse).epsilon(0.02));
  double worst = 0.0;
  for (size_t i = 0; i < kSlabDirections; ++i) {
    const SlabDirection& direction = slab_directions()[i];
    CAPTURE(direction.name());
    const double drawn = (direction.up ? above : below).radiance(direction);
    CHECK(drawn == doctest::Approx(probe.radiance[i]).epsilon(0.15));
    worst = std::max(worst, std::abs(drawn / probe.radiance[i] - 1.0));
  }
  MESSAGE("radiances differ by ", 100.0 * worst, " % at most");
  // No air, stars, ground: the picture is its clouds.
  const std::vector<float>&rgb = above.channel("G"), &cloud = above.channel("cloud.G");
  bool same = true, lit = true;
  for (size_t i = 0; i < rgb.size(); ++i) {
    same = same && std::abs(rgb[i] - cloud[i]) <= 1e-5f * cloud[i];
    lit = lit && std::isfinite(rgb[i]) && rgb[i] > 0.0f;
  }
  CHECK(same);
  CHECK(lit);
}
