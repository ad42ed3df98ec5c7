#include <algorithm>
#include <array>

#include "scene/cloud_params.h"

// Genera and skies. Heights, thicknesses and winds are typical of middle latitudes (WMO International Cloud Atlas); the
// forms are chosen by eye, by pictures from the ground, from 6 km and from orbit.
namespace nepho {

namespace {

constexpr DensityProfile kEven{.linear_term = 0.0, .constant_term = 1.0};
constexpr DensityProfile kDensestAtGround{.linear_term = -0.75, .constant_term = 1.0};
constexpr DensityProfile kDeepTower{.linear_term = 0.5, .constant_term = 0.5};  // ice aloft holds less than its adiabat

CloudLayer cumulus() {
  return {.base_m = 1000.0,
          .base_reference = "terrain",
          .thickness_m = 1400.0,
          .coverage_filter_width = 0.12,
          .top_relief = 1.15,
          .cell_size_m = 2500.0};
}

CloudLayer stratus() {
  return {.base_m = 400.0,
          .base_reference = "terrain",
          .thickness_m = 450.0,
          .density_profile = kEven,
          .shape_amount = 0.35,
          .detail_amount = 0.3,
          .coverage_filter_width = 0.5,
          .top_relief = 0.12,
          .cell_size_m = 4000.0,
          .cell_roundness = 0.2};
}

CloudLayer stratocumulus() {
  return {.base_m = 900.0,
          .base_reference = "terrain",
          .thickness_m = 650.0,
          .shape_amount = 0.6,
          .coverage_filter_width = 0.2,
          .top_relief = 0.45,
          .cell_size_m = 3200.0,
          .cell_roundness = 0.9};
}

CloudLayer altocumulus() {
  return {.weather_channel = "g",
          .base_m = 3800.0,
          .base_reference = "msl",
          .thickness_m = 500.0,
          .density_scale = 0.35,
          .shape_amount = 0.6,
          .detail_amount = 0.4,
          .coverage_filter_width = 0.25,
          .top_relief = 0.5,
          .cell_size_m = 900.0,
          .cell_roundness = 1.0,
          .wind_east_mps = 12.0};
}

CloudLayer cirrus() {
  return {.weather_channel = "b",
          .base_m = 8500.0,
          .base_reference = "msl",
          .thickness_m = 1600.0,
          .density_scale = 0.02,  // extinction 8e-4/m
          .density_profile = kEven,
          .shape_amount = 0.8,
          .detail_amount = 0.3,
          .coverage_filter_width = 1.6,
          .top_relief = 0.3,
          .cell_size_m = 7000.0,
          .cell_roundness = 0.0,
          .stretch = 8.0,
          .cover_optical_depth = 0.1,
          .casts_shadow = false,
          .wind_east_mps = 25.0,
          .shear_east_mps_per_km = 4.0};
}

CloudLayer cumulonimbus() {
  return {.weather_channel = "a",
          .base_m = 700.0,
          .base_reference = "terrain",
          .thickness_m = 11500.0,
          .density_scale = 1.2,
          .density_profile = kDeepTower,
          .shape_amount = 1.0,
          .detail_amount = 0.6,
          .coverage_filter_width = 0.12,
          .top_relief = 0.45,
          .anvil_amount = 1.0,
          .cell_size_m = 14000.0,
          .cell_roundness = 0.8,
          .wind_east_mps = 8.0};
}

CloudLayer fog() {
  return {.base_m = 0.0,
          .base_reference = "terrain",
          .thickness_m = 250.0,
          .density_scale = 0.35,
          .density_profile = kDensestAtGround,
          .shape_amount = 0.3,
          .detail_amount = 0.2,
          .coverage_filter_width = 0.8,
          .top_relief = 0.15,
          .cell_size_m = 3000.0,
          .cell_roundness = 0.2};
}

/// A sea of fog: from below the floors of the valleys up to a little above the smoothed ground.
CloudLayer valley_fog() {
  CloudLayer layer = fog();
  layer.base_m = -700.0;
  layer.thickness_m = 800.0;
  layer.density_profile = kEven;
  return layer;
}

struct Genus {
  const char* name;
  CloudLayer (*layer)();
  double coverage;  ///< of the sky that has this genus alone
};
constexpr std::array kGenera{Genus{"stratus", stratus, 0.8}, Genus{"stratocumulus", stratocumulus, 0.6},
                             Genus{"cumulus", cumulus, 0.3}, Genus{"altocumulus", altocumulus, 0.4},
                             Genus{"cirrus", cirrus, 0.4},   Genus{"cumulonimbus", cumulonimbus, 0.08},
                             Genus{"fog", fog, 0.6}};

/// A layer of a sky whose coverage is `of_sky` times the sky's.
struct Deck {
  CloudLayer (*layer)();
  double of_sky = 1.0;
};
struct Sky {
  const char* name;
  std::optional<double> coverage;  ///< without: the procedural weather
  std::vector<Deck> decks;
};

const std::vector<Sky>& skies() {
  static const std::vector<Sky> all{
      {"earth", {}, {{cumulus}, {cirrus}}},
      {"clear", 0.0, {}},
      {"fair", 0.3, {{cumulus}, {cirrus, 0.4}}},
      {"broken", 0.65, {{stratocumulus}, {cumulus, 0.4}, {altocumulus, 0.5}}},
      {"overcast", 1.0, {{stratus}, {altocumulus, 0.6}}},
      {"storm", 0.4, {{cumulonimbus, 0.4}, {stratocumulus, 1.5}, {cirrus}}},
      {"high-cirrus", 0.6, {{cirrus}}},
      {"valley-fog", 0.8, {{valley_fog}, {cirrus, 0.25}}},
  };
  return all;
}

}  // namespace

std::optional<CloudLayer> cloud_genus(const std::string& name) {
  const auto found = std::find_if(kGenera.begin(), kGenera.end(), [&](const Genus& g) { return name == g.name; });
  if (found == kGenera.end()) return std::nullopt;
  return found->layer();
}

std::vector<std::string> cloud_genus_names() {
  std::vector<std::string> names;
  for (const Genus& genus : kGenera) names.emplace_back(genus.name);
  return names;
}

std::optional<CloudParams> cloud_sky(const std::string& name) {
  CloudParams clouds;
  const auto genus = std::find_if(kGenera.begin(), kGenera.end(), [&](const Genus& g) { return name == g.name; });
  if (genus != kGenera.end()) {
    clouds.coverage = genus->coverage;
    clouds.layers = {genus->layer()};
    return clouds;
  }
  const auto found = std::find_if(skies().begin(), skies().end(), [&](const Sky& s) { return name == s.name; });
  if (found == skies().end()) return std::nullopt;
  clouds.coverage = found->coverage;
  clouds.layers.clear();
  for (const Deck& deck : found->decks) {
    clouds.layers.push_back(deck.layer());
    clouds.layers.back().coverage_scale = deck.of_sky;
  }
  return clouds;
}

std::vector<std::string> cloud_sky_names() {
  std::vector<std::string> names;
  for (const Sky& sky : skies()) names.emplace_back(sky.name);
  for (const Genus& genus : kGenera) names.emplace_back(genus.name);
  return names;
}

}  // namespace nepho
