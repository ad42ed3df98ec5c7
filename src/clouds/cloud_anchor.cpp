#include "clouds/cloud_anchor.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/quaternion.hpp>

namespace nepho {
namespace {

static_assert(sizeof(shared::CloudDomain) == 40);
static_assert(sizeof(shared::CloudAnchor) == 52 * 12 + 16 + 36);
static_assert(shared::kCloudDomains == shared::kDomainOfLayer + shared::kCloudLayers * shared::kLayerDomains);

/// The defaults that relative sizes of lattices are told against: those of a cumulus.
constexpr double kCumulusCell_m = 2500.0;
constexpr double kRegionalPeriod_m = 197.3e3, kMesoPeriod_m = 53.9e3;
constexpr double kCellsPerPeriod = 9.08;  ///< rounded cells along a side of the cells' volume
constexpr double kFinePeriod = 0.2757;    ///< of the detail's

/// How a kind of lattice is turned. Axes and angles are irrational to each other and to ECEF, so that no lattice plane
/// lies along the ground of any place for long and no two lattices share rows.
struct Turn {
  glm::dvec3 axis;
  double angle_rad;
};
constexpr size_t kKinds = shared::kDomainOfLayer + shared::kLayerDomains;
const Turn kTurns[kKinds] = {
    {{0.63, 0.52, -0.57}, 1.41}, {{0.27, -0.48, 0.83}, 0.63}, {{0.31, 0.83, 0.46}, 0.71},   {{-0.72, 0.21, 0.66}, 1.93},
    {{0.57, -0.44, 0.69}, 2.67}, {{0.18, 0.63, -0.75}, 1.27}, {{-0.49, -0.29, 0.82}, 0.97}, {{0.84, 0.35, 0.41}, 2.21},
};

/// Points far apart for consecutive numbers (the R3 sequence of Roberts 2018), within 0..1.
glm::dvec3 scattered(double number) {
  return glm::fract(glm::dvec3(0.8191725134, 0.6710436067, 0.5497004779) * number);
}

CloudLattice lattice(size_t kind, double period_m, double stretch, uint32_t texels, double number) {
  const glm::dmat3 turn = glm::mat3_cast(glm::angleAxis(kTurns[kind].angle_rad, glm::normalize(kTurns[kind].axis)));
  // Longer along x and y is longer along parallels, seen on the ground: fibres.
  const glm::dmat3 narrow(glm::dvec3(1.0 / stretch, 0, 0), glm::dvec3(0, 1.0 / stretch, 0), glm::dvec3(0, 0, 1));
  return {turn * narrow * (1.0 / period_m), scattered(number), period_m / texels};
}

}  // namespace

CloudLattices make_cloud_lattices(const CloudParams& params, const std::vector<CloudLayer>& layers,
                                  const CloudTexels& texels) {
  CloudLattices all;
  const double seed = 64.0 * params.weather.seed;
  all[shared::kDomainTurbulence] =
      lattice(shared::kDomainTurbulence, params.noise.turbulence.period_m, 1.0, texels.turbulence, seed + 2.0);
  all[shared::kDomainTurbulence].start += params.noise.turbulence.offset;
  // The tile lies along ECEF's axes: its planes are those of the cube's faces.
  all[shared::kDomainTile] = {glm::dmat3(1.0 / params.weather.tile_period_m), params.weather.tile_offset,
                              params.weather.tile_period_m / texels.tile};
  for (size_t l = 0; l < layers.size(); ++l) {
    const CloudLayer& layer = layers[l];
    const double size = layer.cell_size_m / kCumulusCell_m;
    const double channel = 8.0 + 8.0 * static_cast<double>(std::string("rgba").find(layer.weather_channel));
    const auto put = [&](uint32_t kind, double period_m, double stretch, uint32_t side,
                         const glm::dvec3& offset = glm::dvec3(0.0)) {
      CloudLattice& to = all[shared::kDomainOfLayer + l * shared::kLayerDomains + kind];
      to = lattice(shared::kDomainOfLayer + kind, period_m, stretch, side, seed + channel + kind);
      to.start += offset;
    };
    const double some = std::sqrt(layer.stretch);
    put(shared::kRegional, kRegionalPeriod_m, some, texels.field);
    put(shared::kMeso, kMesoPeriod_m * std::sqrt(size), some, texels.field);
    put(shared::kCell, kCellsPerPeriod * layer.cell_size_m, layer.stretch, texels.cells);
    put(shared::kShape, params.noise.shape.period_m * std::sqrt(size), layer.stretch, texels.shape,
        params.noise.shape.offset);
    const double detail_m = params.noise.detail.period_m * std::pow(size, 0.25);
    put(shared::kDetail, detail_m, layer.stretch, texels.detail, params.noise.detail.offset);
    put(shared::kFine, detail_m * kFinePeriod, layer.stretch, texels.detail, params.noise.detail.offset);
  }
  return all;
}

CloudPhases cloud_phases(double time_s) {
  CloudPhases p;
  const double window = std::floor(time_s / kWindow_s);
  const double since = time_s - window * kWindow_s;  // 0..kWindow_s
  p.window[0] = p.window[1] = static_cast<int64_t>(window);
  p.age_s[0] = p.age_s[1] = since - 0.5 * kWindow_s;
  const double half = 0.5 * kWindowOverlap_s;
  double share = 0.0;  // of the neighbour
  if (since < half) {
    p.window[1] -= 1;
    p.age_s[1] += kWindow_s;
    share = 0.5 - 0.5 * since / half;
  } else if (since > kWindow_s - half) {
    p.window[1] += 1;
    p.age_s[1] -= kWindow_s;
    share = 0.5 - 0.5 * (kWindow_s - since) / half;
  }
  p.count = share > 0.0 ? 2 : 1;
  p.weight = {std::cos(0.5 * M_PI * share), std::sin(0.5 * M_PI * share)};
  return p;
}

shared::CloudAnchor make_cloud_anchor(const CloudLattices& lattices, const CloudParams& params,
                                      const glm::dvec3& camera_ecef_m, double time_s) {
  shared::CloudAnchor anchor{};
  const CloudPhases phases = cloud_phases(time_s);
  for (uint32_t d = 0; d < shared::kCloudDomains; ++d)
    for (uint32_t k = 0; k < shared::kCloudPhases; ++k) {
      // Another window is another part of the same noise. The tile is no noise: it stays.
      const glm::dvec3 window = d == shared::kDomainTile
                                    ? glm::dvec3(0.0)
                                    : scattered(0.5 + 1.7 * static_cast<double>(phases.window[k] % 1000003));
      anchor.offsets[d * shared::kCloudPhases + k] =
          glm::vec3(glm::fract(lattices[d].uvw_from_ecef * camera_ecef_m + lattices[d].start + window));
    }
  anchor.age_s = glm::vec2(static_cast<float>(phases.age_s[0]), static_cast<float>(phases.age_s[1]));
  anchor.weight = glm::vec2(static_cast<float>(phases.weight[0]), static_cast<float>(phases.weight[1]));
  // Noon of 2000-01-01 is where the map is as it was made.
  const double turn = std::remainder(params.weather.drift_east_mps * (time_s - 43200.0) / 6378137.0, 2.0 * M_PI);
  anchor.weather_from_ecef = glm::mat3(glm::mat3_cast(glm::angleAxis(-turn, glm::dvec3(0.0, 0.0, 1.0))));
  return anchor;
}

}  // namespace nepho
