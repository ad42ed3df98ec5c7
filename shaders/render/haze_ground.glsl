// Light on the ground under haze. Needs `frame`, HAZE_GROUND_BINDING and the specialisation constant HAZE, layers of it.
#ifndef NEPHO_HAZE_GROUND_GLSL
#define NEPHO_HAZE_GROUND_GLSL
#include "render/shaft_shared.h"
layout(scalar, set = 0, binding = HAZE_GROUND_BINDING) uniform ShaftBlock { ShaftData data; } shafts;

struct HazeGround {
  float beam;       // share of the key light that arrives, its forward peak with it
  float scattered;  // illuminance of horizontal ground by what haze scattered of it, per key light on a facing plane
  float sky;        // share of the sky's light that arrives
};

HazeGround haze_over_ground(vec3 p_cam, float mu_key) {
  HazeGround ground = HazeGround(1.0, 0.0, 1.0);
  float h = scaled_height_from_f(frame.frame_data.planet, planet_f(frame.frame_data.planet, p_cam));
  float along = 0.0, above = 0.0, albedo = 0.0, extinction = 1.0e-12, mu0 = max(mu_key, 0.03);
  for (uint l = 0u; l < HAZE; ++l) {
    HazeLayerData layer = shafts.data.haze.layers[l];
    along += layer.extinction_per_m * (1.0 - layer.albedo * layer.g * layer.g) * haze_column(layer, shafts.data.haze.radius_m, h, mu_key, 1.0e7);
    float column = layer.extinction_per_m * haze_column_above(layer, h);
    above += (1.0 - layer.albedo * layer.g) * column;
    albedo += column * haze_isotropic_albedo(layer.albedo, layer.g);
    extinction += column;
  }
  above = min(above, 60.0);
  HazeDiffuse diffuse = haze_diffuse_beam(above, above, mu0);
  float survival = haze_survival(min(albedo / extinction, 1.0), above);
  ground.beam = exp(-min(along, 80.0));
  ground.scattered = max(mu0 * exp(-above / mu0) + diffuse.ground * survival - mu0 * ground.beam, 0.0);
  // Even light that is only absorbed falls like a beam at 53 degrees.
  ground.sky = mix(exp(-1.66 * above), haze_sky_flux(above), survival);
  return ground;
}
#endif
