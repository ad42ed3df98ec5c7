// terrain_volume_share() for marches whose heights and light angles are known along the ray, with polynomials for arcs: within half a per
// cent of it. Include after terrain/terrain_air.glsl.
#ifndef NEPHO_TERRAIN_TERRAIN_RAY_GLSL
#define NEPHO_TERRAIN_TERRAIN_RAY_GLSL

// disc_share() of terrain_shadow_shared.h, to 0.5 %.
float disc_share_near(float clear) {
  float x = clamp(clear, -1.0, 1.0);
  return 0.5 + x * (0.6366 - 0.1366 * x * x);
}

// Camera-relative point, ECEF axes; its height, scaled and geodetic; the key light's cosine to the vertical there.
float terrain_ray_share(vec3 point, float scaled_height_m, float height_m, float mu) {
  PlanetView planet = frame.frame_data.planet;
  RegionMap map = terrain_volume.map;
  vec2 xy = region_xy(map, planet_q(planet, point) / (planet.a_m + scaled_height_m));
  float away = max(abs(xy.x), abs(xy.y));
  float level = max(floor(log2(max(away * (float(kShadowTexels) / float(kShadowTexels - 1u)) / map.half_m, 0.5))) + 1.0, 0.0);
  vec4 edge = textureLod(terrain_volume_tex, vec3(xy * (0.5 / (map.half_m * exp2(level))) + 0.5, min(level, float(map.levels - 1u))), 0.0);
  float share = disc_share_near(min((height_m - edge.x) / edge.y, (height_m - edge.z) / edge.w));
  float elevation = mu * (1.0 + mu * mu / 6.0);  // where it is small it counts
  float whole = disc_share_near((elevation + sqrt(2.0 * max(height_m, 0.0) / planet.a_m)) / frame.frame_data.sun_angular_radius_rad);
  return TERRAIN && level < float(map.levels) && whole > 0.0 ? min(share / whole, 1.0) : 1.0;
}
#endif
