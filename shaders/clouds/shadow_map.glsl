// How much of the key light (the sun; at night the moon) passes the clouds between it and any point: on the ground, in the
// air, inside clouds. Needs what clouds/cloud_density.glsl needs.
#ifndef NEPHO_SHADOW_MAP_GLSL
#define NEPHO_SHADOW_MAP_GLSL
#include "clouds/cloud_shadow_march.glsl"
#endif
