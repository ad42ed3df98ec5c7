// Cases for atmosphere_probe.comp: one row of a table of questions to the atmosphere's functions.
#ifndef NEPHO_ATMOSPHERE_PROBE_SHARED_H
#define NEPHO_ATMOSPHERE_PROBE_SHARED_H
#include "common/planet.h"
SHARED_BEGIN

SHARED_CONST uint kProbeSkyRadiance = 0u;       // a: radiance, b: transmittance, along `dir` to space or the ground
SHARED_CONST uint kProbeRadianceToPoint = 1u;   // the same to `distance_m`
SHARED_CONST uint kProbeSingleScattering = 2u;  // a: gas, b: aerosol, without phase function, for h, mu, mu_s, nu
SHARED_CONST uint kProbeIrradiance = 3u;        // a: direct, b: sky, on a horizontal plane, for h, mu_s
SHARED_CONST uint kProbeTransmittance = 4u;     // a: to the top, for h, mu
SHARED_CONST uint kProbeLuminance = 5u;         // a: luminance of the sky, b: of the air over distance_m
SHARED_CONST uint kProbeSunTransmittance = 6u;  // a: sun_transmittance for h, mu_s; b: mean_sky_luminance
SHARED_CONST uint kProbeSunSky = 7u;  // a: sun, b: sky, on the plane with normal `dir` under camera_up, for h, mu_s

struct AtmosphereCase {
  PlanetView planet;
  vec3 dir;  // unit
  float distance_m;
  vec3 sun_dir;  // unit
  uint hits_ground;
  vec3 camera_up;
  float h;
  float mu, mu_s, nu;
  float shadow_m;  // of the path to a point: its last metres without sunlight
  uint view;       // sky view of this camera and sun; AtmosphereProbe fills it in
};

struct AtmosphereAnswer {
  vec3 a, b;
};

SHARED_END
#endif
