#pragma once
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "gpu/gpu_fixture.h"
#include "render/renderer.h"

namespace nepho::test {

/// NEPHO_TEST_FULL=1 asks for the figures of the issue at their full sizes, which take minutes.
inline bool full_size() {
  const char* full = std::getenv("NEPHO_TEST_FULL");
  return full && std::string(full) == "1";
}

/// A genus above the ellipsoid, so that it needs no rasters, over half of the sky.
inline CloudParams half_sky(const std::string& genus, double coverage = 0.5) {
  CloudParams clouds;
  clouds.coverage = coverage;
  clouds.layers = {cloud_genus(genus).value()};
  clouds.layers[0].base_reference = "ellipsoid";
  return clouds;
}

/// A small picture from below the clouds, up and towards the morning sun.
inline Scene reference_scene(const CloudParams& clouds, Extent2D size, uint32_t seed = 0) {
  Scene scene;
  scene.time = "2026-06-20T23:30:00Z";
  scene.camera.lat_deg = 35.5;
  scene.camera.lon_deg = 138.75;
  scene.camera.height_m = 300.0;
  scene.camera.heading_deg = 60.0;
  scene.camera.pitch_deg = 25.0;
  scene.atmosphere.spectral = "fast";
  scene.atmosphere.scattering_orders = 2;
  scene.night_sky.stars = false;
  scene.clouds = clouds;
  scene.terrain.default_earth = false;
  scene.render.width = size.width;
  scene.render.height = size.height;
  scene.render.quality = "reference";
  scene.render.frames = 1u << 20;  // ended by draw_to()
  scene.render.seed = seed;
  return scene;
}

/// Draws until each pixel has `paths` paths, which must be a level that SamplePlan::next_check() gives, going on from
/// `earlier` if that is given.
inline ImageBuffer draw_to(Renderer& renderer, double paths, const ImageBuffer* earlier = nullptr) {
  RenderRequest request;
  request.display = false;
  request.resume = earlier;
  request.on_progress = [paths](const ReferenceProgress& at) { return at.paths < paths; };
  RenderResult result = renderer.render(request);
  CHECK(result.reference.paths == paths);
  return std::move(result.layers);
}

inline const std::vector<float>& channel(const ImageBuffer& image, const std::string& name) {
  const ImageChannel* c = image.find(name);
  REQUIRE_MESSAGE(c != nullptr, name);
  return c->values;
}

}  // namespace nepho::test
