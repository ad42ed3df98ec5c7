#include "scene/shaft_fields.h"

#include "scene/field_ranges.h"

namespace nepho {

namespace {

const Range kHazeHeights = closed(-12000.0, 1e5);

void describe(FieldVisitor& v, HazeLayer& p) {
  v.leaf({.name = "extinction_per_m",
          .doc = "extinction coefficient at base_m; haze 1e-4, mist 1e-3, fog 1e-2 and more; 0 leaves the layer out",
          .unit = "1/m",
          .range = closed(0, 10),
          .term = "3.912 / visibility (Koschmieder 1924)",
          .other_names = "fog density"},
         &p.extinction_per_m);
  v.leaf({.name = "base_m",
          .doc = "height above the ellipsoid up to which the density is even; it falls above",
          .unit = "m",
          .range = kHazeHeights},
         &p.base_m);
  v.leaf({.name = "scale_height_m",
          .doc = "height over which the density falls by e above base_m",
          .unit = "m",
          .range = closed(0.1, 1e5),
          .term = "scale height",
          .other_names = "1 / fog height falloff"},
         &p.scale_height_m);
  v.leaf({.name = "bottom_m",
          .doc = "height above the ellipsoid below which there is nothing; null: it reaches the ground",
          .unit = "m",
          .range = kHazeHeights},
         &p.bottom_m);
  v.leaf({.name = "top_m",
          .doc = "height above the ellipsoid above which there is nothing; null: no such height",
          .unit = "m",
          .range = kHazeHeights},
         &p.top_m);
  v.leaf({.name = "albedo",
          .doc = "share of the extinction that is scattering; droplets 1, dust 0.9, smoke 0.8",
          .range = share(),
          .term = "single-scattering albedo"},
         &p.albedo);
  v.leaf({.name = "phase_g",
          .doc = "asymmetry of its scattering; towards 1 the glow around the sun is smaller and brighter",
          .range = closed(-0.95, 0.95),
          .term = "g of Henyey-Greenstein 1941"},
         &p.phase_g);
}

}  // namespace

std::string resolved_shaft_method(const ShaftParams& params, const std::string& quality) {
  if (params.method != "auto") return params.method;
  if (quality == "low") return "screen";
  return quality == "medium" ? "froxel" : "shadow-length";
}

std::vector<HazeLayer> drawn_haze(const HazeParams& params) {
  std::vector<HazeLayer> drawn;
  if (!params.enabled) return drawn;
  for (const HazeLayer& layer : params.layers)
    if (layer.extinction_per_m > 0.0) drawn.push_back(layer);
  return drawn;
}

void describe(FieldVisitor& v, ShaftParams& p) {
  v.leaf({.name = "method",
          .doc = "how the air in the shade of clouds is found: shadow-length marches every ray; froxel fills a grid of "
                 "the frustum; screen blurs the picture away from the sun; auto: shadow-length at quality high and "
                 "ultra, froxel at medium (above 30 km shadow-length), screen at low",
          .term = "crepuscular rays; volumetric lighting (froxel: Wronski 2014; screen: Mitchell 2007)",
          .other_names = "lightShafts",
          .choices = {"auto", "none", "shadow-length", "froxel", "screen"}},
         &p.method);
  v.leaf({.name = "intensity",
          .doc = "0 none, 1 as nature has it; above 1 half shade counts as more",
          .range = closed(0, 4)},
         &p.intensity);
  v.leaf({.name = "steps",
          .doc = "points of a ray that look for the sun, of shadow-length and screen; more is slower and smoother",
          .range = closed(4, 256),
          .other_names = "maxShadowLengthIterationCount"},
         &p.steps);
  v.leaf({.name = "downscale",
          .doc = "side of the blocks of pixels that share a ray, of shadow-length and screen; less where that is more "
                 "than half a degree, more in pictures of over 540 rows",
          .unit = "px",
          .range = closed(1, 8)},
         &p.downscale);
  v.leaf({.name = "froxels_wide", .doc = "cells of the frustum grid across the picture", .range = closed(4, 512)},
         &p.froxels_wide);
  v.leaf({.name = "froxels_high", .doc = "cells of the frustum grid down the picture", .range = closed(4, 512)},
         &p.froxels_high);
  v.leaf({.name = "froxel_slices",
          .doc = "cells of the frustum grid along a ray, exponential in distance",
          .range = closed(8, 256)},
         &p.froxel_slices);
  v.leaf({.name = "froxel_range_m",
          .doc = "distance where the frustum grid ends; no shafts and no haze beyond it",
          .unit = "m",
          .range = closed(1000, 1e7)},
         &p.froxel_range_m);
  v.leaf({.name = "screen_glow", .doc = "screen: the sun's glow over the clouds around it", .range = closed(0, 10)},
         &p.screen_glow);
}

void describe(FieldVisitor& v, HazeParams& p) {
  v.leaf({.name = "enabled", .doc = "whether the layers are drawn"}, &p.enabled);
  v.items({.name = "layers",
           .doc = "layers of haze and fog that add up",
           .term = "exponential height fog",
           .standard = "none"},
          {.max = 4,
           .size = [&p] { return p.layers.size(); },
           .resize = [&p](size_t n) { p.layers.resize(n); },
           .visit = [&p](FieldVisitor& visitor, size_t i) { describe(visitor, p.layers[i]); },
           .visit_default =
               [](FieldVisitor& visitor) {
                 HazeLayer defaults;
                 describe(visitor, defaults);
               }});
}

}  // namespace nepho
