#include "scene/shadow_fields.h"

#include "scene/field_ranges.h"

namespace nepho {

void describe(FieldVisitor& v, CloudShadowParams& p) {
  v.leaf({.name = "enabled",
          .doc = "false: clouds cast no shadows on the ground and in the air",
          .other_names = "castShadow"},
         &p.enabled);
  v.leaf({.name = "cascades",
          .doc = "shadow maps, each for a range of distances",
          .range = closed(1, 4),
          .term = "cascaded shadow maps (Engel 2006)",
          .other_names = "shadow.cascadeCount"},
         &p.cascades);
  v.leaf({.name = "resolution",
          .doc = "texels along a side of each map, in whole tiles of 8",
          .range = closed(128, 1024),
          .other_names = "shadow.mapSize"},
         &p.resolution);
  v.leaf({.name = "split",
          .doc = "how the range is split among the maps: at equal distances, at equal ratios, or between the two",
          .term = "parallel-split shadow maps (Zhang et al. 2006)",
          .other_names = "shadow.splitMode",
          .choices = {"uniform", "logarithmic", "practical"}},
         &p.split);
  v.leaf({.name = "split_lambda",
          .doc = "practical: 0 is uniform, 1 logarithmic",
          .range = share(),
          .term = "lambda of the practical split scheme",
          .other_names = "shadow.splitLambda"},
         &p.split_lambda);
  v.leaf({.name = "far_m",
          .doc = "distance from the camera up to which there are shadows; 0: by the camera's height, up to the whole "
                 "visible disc",
          .unit = "m",
          .range = closed(0, 1e9),
          .other_names = "shadow.maxFar"},
         &p.far_m);
  v.leaf({.name = "slices",
          .doc = "frames over which maps are made anew that are off by less than half a texel; others are at once",
          .range = closed(1, 64)},
         &p.slices);
  v.leaf({.name = "rounds",
          .doc = "marches, each shifted within its texel, that maps of an unchanging sky end up as the mean of",
          .range = closed(1, 64),
          .term = "temporal resolve",
          .other_names = "shadow.temporalPass"},
         &p.rounds);
}

}  // namespace nepho
