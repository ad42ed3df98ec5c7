#version 460
#extension GL_GOOGLE_include_directive : require
// Fills the frustum grid: air in the shade of clouds, and haze.
#include "common/frame.h"
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define CLOUD_BINDING 1
#include "clouds/shadow_map.glsl"
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
#define SHAFT_BINDING 19
#define TERRAIN_VOLUME_BINDING 40
#define TERRAIN_CONSTANT 9
#include "terrain/terrain_air.glsl"
#define AIR_VISIBLE(p) (cloud_sun_transmittance(p) * terrain_air_share(p))
#include "render/shaft_air.glsl"
#include "render/froxel_fill.glsl"
