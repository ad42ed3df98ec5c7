#version 460
#extension GL_GOOGLE_include_directive : require
// Vertical optical depths of a square of columns around the point below the camera, by the march's own density.
#include "common/frame.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
layout(push_constant, scalar) uniform Push { CloudColumnsPush push; };
layout(set = 0, binding = 20, r32f) uniform writeonly image2D out_depth;

void main() {
  uvec2 id = gl_GlobalInvocationID.xy;
  if (id.x >= push.count || id.y >= push.count) return;
  PlanetView planet = frame.frame_data.planet;
  vec2 at = ((vec2(id) + 0.5) / float(push.count) - 0.5) * push.side_m;
  vec3 p = at.x * push.east - at.y * push.north;  // a tangent plane, then down to the ellipsoid
  for (int i = 0; i < 3; ++i) p -= geodetic_up(planet, p) * geodetic_height(planet, p);
  vec3 up = geodetic_up(planet, p);
  float log2_footprint = log2(push.footprint_m);
  float step_m = CLOUD.thickness_m / float(push.steps);
  float tau = 0.0;
  for (uint i = 0u; i < push.steps; ++i) {
    float h = CLOUD.base_m + (float(i) + 0.5) * step_m;
    float eta = (h - CLOUD.base_m) / CLOUD.thickness_m;
    vec3 q = p + up * h;
    CloudColumn column = cloud_column(q, up, h, log2_footprint);
    float unknown = column.unknown;
    float level = cloud_cell_level(column, q, up, h, eta, log2_footprint, unknown);
    level += cloud_shape_level(q, eta, log2_footprint, unknown);
    level += cloud_detail_level(q, eta, log2_footprint, unknown);
    tau += cloud_extinction(level, unknown, 0.0, eta, push.footprint_m) * step_m;
  }
  imageStore(out_depth, ivec2(id), vec4(tau));
}
