// The clouds' shade at many points of one ray through the air (shadow_map.glsl), for marches: places in the maps are linear in the
// distance, and one texel is read where shadow_map.glsl reads four or eight. Between texels and between maps the choice changes
// from look to look, so that the mean of several looks is smooth.
//
// Include after clouds/shadow_map.glsl.
#ifndef NEPHO_SHADOW_RAY_GLSL
#define NEPHO_SHADOW_RAY_GLSL

struct ShadowRay {
  vec3 origin[4], slope[4];  // place in each cascade: texels, stored depth
  vec2 rise[4];              // stored depth per texel of a layer, where texels are wide (shadow_read())
  vec3 height;               // scaled, at a distance t: from f = x + t (y + t z), |q|^2 - a^2
  float geodetic;            // geodetic height per scaled height, at the camera
  float below;               // the share under the clouds where no map is
};

// `up`: the vertical, of the camera or nearer to what is seen.
ShadowRay shadow_ray(vec3 dir, vec3 up) {
  ShadowRay ray;
  PlanetView planet = CLOUD_PLANET;
  vec3 scaled = scaled_from_cam(planet, dir);
  ray.height = vec3(planet.camera_f_m2, 2.0 * dot(scaled, planet.camera_q_m), dot(scaled, scaled));
  ray.geodetic = 1.0 / scaled_height_from_geodetic(planet, planet.camera_q_m, 1.0);
  ray.below = shadow_beyond(SHADOW.outside, SHADOW.slant, dot(up, SHADOW.light));
  for (int k = 0; k < 4; ++k) {
    ray.origin[k] = shadow_point(SHADOW.at[k], vec3(0.0));
    ray.slope[k] = shadow_point(SHADOW.at[k], dir) - ray.origin[k];
    float flat_part = clamp(5.0 * SHADOW.at[k].texel_m / SHADOW.thickness_m - 0.5, 0.0, 1.0);
    ray.rise[k] = vec2(dot(up, SHADOW.axis_x), dot(up, SHADOW.axis_y)) *
                  (flat_part * SHADOW.at[k].texel_m / (max(dot(up, SHADOW.light), 0.05) * SHADOW.at[k].depth_unit_m));
  }
  return ray;
}

// Three numbers in 0..1 that fill the cube evenly as `look` counts (Roberts 2018).
vec3 shadow_shift(uint look) { return fract(0.5 + float(look) * vec3(0.8191725134, 0.6710436067, 0.5497004779)); }

// Scaled height at a distance, m.
float shadow_ray_height(ShadowRay ray, float t_m) {
  return scaled_height_from_f(CLOUD_PLANET, ray.height.x + t_m * (ray.height.y + t_m * ray.height.z));
}

// Share of the key light at a distance; `shift` decides which texel and which map.
float shadow_ray_look(ShadowRay ray, float t_m, vec3 shift) {
  float sum = -1.0;
  // The first map that reaches there, and the next ones where it has nothing yet.
  for (int from = 0; from < 4 && sum < 0.0;) {
    int k = 4;
    vec3 at = vec3(0.0);
    vec2 rise = vec2(0.0);
    uvec2 first = uvec2(0u);
    for (int i = 3; i >= 0; --i) {
      bool reaches = i >= from && uint(i) < SHADOW.cascades && t_m < mix(SHADOW.at[i].fade_m, SHADOW.at[i].reach_m, shift.z);
      k = reaches ? i : k;
      at = reaches ? ray.origin[i] + t_m * ray.slope[i] : at;
      rise = reaches ? ray.rise[i] : rise;
      first = reaches ? SHADOW.at[i].first : first;
    }
    from = k + 1;
    if (k == 4) break;
    uint tiles = SHADOW.resolution / kShadowTile;
    uvec2 tile = uvec2(clamp(at.xy / float(kShadowTile), vec2(0.0), vec2(float(tiles) - 0.5)));
    uint bit = tile.y * tiles + tile.x;
    bool usable = (SHADOW.usable[uint(k) * kShadowWords + (bit >> 5)] >> (bit & 31u) & 1u) != 0u;
    uvec2 texel = uvec2(clamp(at.xy + shift.xy - 0.5, vec2(0.0), vec2(float(SHADOW.resolution) - 1.0)));
    uvec2 place = texel + first;
    place -= uvec2(greaterThanEqual(place, uvec2(SHADOW.resolution))) * SHADOW.resolution;
    uvec4 stored = texelFetch(cloud_shadow_map, ivec3(place, k), 0);
    float tau = shadow_depth_at(stored, clamp(at.z + dot(rise, vec2(texel) + 0.5 - at.xy), 0.0, 65535.0));
    sum = usable ? exp(-tau) : -1.0;
  }
  // Scaled heights are up to a third of a per cent above geodetic ones: nothing against a mean.
  float height_m = shadow_ray_height(ray, t_m);
  float outside = mix(ray.below, 1.0, clamp((height_m - SHADOW.hull_low_m) / (SHADOW.hull_high_m - SHADOW.hull_low_m), 0.0, 1.0));
  return sum < 0.0 ? outside : sum;
}
#endif
