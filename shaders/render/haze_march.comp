#version 460
#extension GL_GOOGLE_include_directive : require
// Haze and shafts without the shade of clouds.
#include "common/frame.h"
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
#define SHAFT_BINDING 19
#define TERRAIN_VOLUME_BINDING 40
#define TERRAIN_CONSTANT 9
#include "terrain/terrain_air.glsl"
#define AIR_VISIBLE(p) 1.0
#define AIR_BLOCK(block)
#define AIR_RAY(dir)
#define AIR_LOOK(t, number) terrain_air_share(dir * (t))
#define AIR_LOOKS (TERRAIN ? 3 : 1)
#include "render/shaft_air.glsl"
#include "render/shaft_march.glsl"
