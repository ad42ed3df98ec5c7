#version 460
#extension GL_GOOGLE_include_directive : require
// Group counts of light_gather.comp for the cells and nodes that want paths, in full and one each.
#include "clouds/light_shared.h"
layout(local_size_x = 1) in;
layout(scalar, set = 0, binding = 0) uniform LightBlock { CloudLightConstants data; } light;
layout(scalar, set = 0, binding = 1) readonly buffer WorkBlock { LightWork data; } work;
layout(scalar, set = 0, binding = 2) writeonly buffer Args0 { uvec3 groups; } cell_args;
layout(scalar, set = 0, binding = 3) writeonly buffer Args1 { uvec3 groups; } ground_args;

uvec3 groups_for(uint fresh, uint refresh) {
  uint groups = light_groups(fresh, light_threads(light.data.cells)) + light_groups(refresh, 1u);
  return uvec3(min(groups, kLightGroupsAcross), (groups + kLightGroupsAcross - 1u) / kLightGroupsAcross, 1u);
}

void main() {
  cell_args.groups = groups_for(work.data.fresh, work.data.refresh);
  ground_args.groups = groups_for(work.data.ground_fresh, work.data.ground_refresh);
}
