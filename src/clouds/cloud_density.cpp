#include "clouds/cloud_density.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace nepho {
namespace {

static_assert(sizeof(shared::CloudDomain) == 52);
static_assert(sizeof(shared::CloudConstants) == 7 * 52 + 36 + 12 * 4 + 2 * 16);

/// How a noise lattice lies: its period, the axis and angle of its turn. Axes and angles are irrational to each other
/// and to ECEF, so that no lattice plane lies along the ground of any place for long and no two lattices share rows.
struct Lattice {
  double period_m;
  glm::dvec3 axis;
  double turn_rad;
  uint32_t texels;
};
const Lattice kLattices[shared::kCloudDomains] = {
    {197.3e3, {0.31, 0.83, 0.46}, 0.71, 128},   {53.9e3, {-0.72, 0.21, 0.66}, 1.93, 128},
    {22.7e3, {0.57, -0.44, 0.69}, 2.67, 128},   {6.13e3, {0.18, 0.63, -0.75}, 1.27, 128},
    {497.0, {-0.49, -0.29, 0.82}, 0.97, 32},    {137.0, {0.84, 0.35, 0.41}, 2.21, 32},
    {1131.0e3, {-0.22, 0.71, 0.67}, 2.83, 128},
};

/// Turn of the whole field about the polar axis: the only wind that is one motion of the sphere, everywhere.
double wind_turn_rad(const FrameInfo& frame, const CloudParams& params) {
  return std::remainder(params.wind_east_mps * frame.time_s / 6378137.0, 2.0 * M_PI);
}

}  // namespace

bool draws_nothing(const CloudParams& params) {
  return params.coverage <= 0.0 || params.layers.empty() || params.layers[0].thickness_m <= 0.0 ||
         params.layers[0].extinction_per_m <= 0.0;
}

shared::CloudConstants make_cloud_constants(const FrameInfo& frame, const CloudParams& params, const CloudNoise& noise,
                                            const WeatherMap& weather) {
  shared::CloudConstants c{};
  const CloudLayer layer = params.layers.empty() ? CloudLayer{.thickness_m = 0.0} : params.layers[0];
  const glm::dmat3 field_from_ecef =
      glm::mat3_cast(glm::angleAxis(-wind_turn_rad(frame, params), glm::dvec3(0.0, 0.0, 1.0)));
  for (uint32_t i = 0; i < shared::kCloudDomains; ++i) {
    const Lattice& lattice = kLattices[i];
    const glm::dmat3 turn = glm::mat3_cast(glm::angleAxis(lattice.turn_rad, glm::normalize(lattice.axis)));
    const glm::dmat3 uvw_from_ecef = turn * field_from_ecef * (1.0 / lattice.period_m);
    const double seed = static_cast<double>(params.weather_seed) + 0.37 * i;
    const glm::dvec3 start = glm::dvec3(0.754877666, 0.569840291, 0.430159709) * seed;  // R3 sequence: seeds far apart
    c.domains[i].uvw_from_cam = glm::mat3(uvw_from_ecef);
    c.domains[i].offset = glm::vec3(glm::fract(uvw_from_ecef * frame.camera_ecef_m + start));
    c.domains[i].log2_texel_m = static_cast<float>(std::log2(lattice.period_m / lattice.texels));
  }
  c.weather_from_ecef = glm::mat3(field_from_ecef);
  c.base_m = static_cast<float>(layer.base_m);
  c.thickness_m = static_cast<float>(layer.thickness_m);
  c.extinction_per_m = static_cast<float>(layer.extinction_per_m);
  c.coverage = static_cast<float>(params.coverage);
  c.shape_amount = static_cast<float>(layer.shape_amount);
  c.detail_amount = static_cast<float>(layer.detail_amount);
  c.log2_weather_texel_m = static_cast<float>(std::log2(weather.texel_m()));
  c.phase_g_forward = static_cast<float>(params.phase_g_forward);
  c.phase_g_backward = static_cast<float>(params.phase_g_backward);
  c.phase_backward_weight = static_cast<float>(params.phase_backward_weight);
  c.ground_albedo = kGroundAlbedo;
  c.uniform_density = static_cast<float>(params.uniform_density);
  c.fade_start = noise.fade_start();
  c.fade_per_lod = noise.fade_per_lod();
  return c;
}

CloudDensityRefs import_cloud_density(FrameGraph& graph, const FrameInfo& frame, const CloudParams& params,
                                      const CloudNoise& noise, const WeatherMap& weather) {
  return {.constants = graph.constants("clouds.constants", make_cloud_constants(frame, params, noise, weather)),
          .weather = weather.import_into(graph),
          .noise = noise.import_into(graph)};
}

void bind_density(FrameGraph::PassBuilder& pass, const CloudDensityRefs& refs) {
  pass.uniform("cloud", refs.constants)
      .sample("cloud_weather", refs.weather)
      .sample("cloud_field", refs.noise.field, Sampler::linear_repeat)
      .sample("cloud_shape", refs.noise.shape, Sampler::linear_repeat)
      .sample("cloud_detail", refs.noise.detail, Sampler::linear_repeat);
}

}  // namespace nepho
