// Terrain's shade in the air for passes that may have none: TERRAIN_CONSTANT is the number of a specialisation constant, false
// where there is none (what is bound is not read then). Needs TERRAIN_VOLUME_BINDING and `frame`.
#ifndef NEPHO_TERRAIN_TERRAIN_AIR_GLSL
#define NEPHO_TERRAIN_TERRAIN_AIR_GLSL
#include "terrain/terrain_volume.glsl"
layout(constant_id = TERRAIN_CONSTANT) const bool TERRAIN = false;

float terrain_air_share(vec3 p_cam) { return TERRAIN ? terrain_volume_share(p_cam) : 1.0; }

#endif
