#version 460
#extension GL_GOOGLE_include_directive : require
// Haze without shade.
#include "common/frame.h"
layout(scalar, set = 0, binding = 0) uniform FrameBlock { FrameConstants frame_data; } frame;
#define ATMOSPHERE_BINDING 12
#include "atmosphere/atmosphere_lookup.glsl"
#define SHAFT_BINDING 19
#define AIR_VISIBLE(p) 1.0
#define AIR_BLOCK(block)
#include "render/shaft_air.glsl"
#include "render/shaft_march.glsl"
