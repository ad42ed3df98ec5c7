// What the cloud probes share: one case per invocation, each with its own camera and clock.
#ifndef NEPHO_CLOUD_PROBE_GLSL
#define NEPHO_CLOUD_PROBE_GLSL
#include "clouds/clouds_shared.h"
#include "common/frame.h"
layout(local_size_x = 64) in;
layout(set = 0, binding = 20, scalar) readonly buffer Cases { CloudCase at[]; } cases;
#define CLOUD_CASE cases.at[gl_GlobalInvocationID.x]
#define CLOUD_ANCHOR CLOUD_CASE.anchor
#define CLOUD_PLANET CLOUD_CASE.planet
#define CLOUD_BINDING 1
#include "clouds/cloud_density.glsl"
layout(push_constant, scalar) uniform Push { uint count; } push;
#endif
