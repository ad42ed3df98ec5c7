#version 460
#extension GL_GOOGLE_include_directive : require
// The large-scale weather: four numbers per direction, higher is cloudier (low, middle, high clouds, deep convection),
// which the CPU turns into ranks (weather_generator.cpp), and the properties. docs/weather.md has the reasoning.
// Everything is a function of the place on the sphere, so cube edges, poles and the antimeridian cannot show.
#include "weather/weather_noise.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1) uniform samplerCube origin_tex;
layout(set = 0, binding = 2) uniform samplerCube recent_tex;
layout(set = 0, binding = 3, rgba32f) uniform writeonly image2DArray out_weather;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2DArray out_properties;

float bump(float x, float centre, float width) {
  float t = (x - centre) / width;
  return exp(-t * t);
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  uint size = generate.generate_data.size;
  if (id.x >= size || id.y >= size) return;
  uint seed = generate.generate_data.seed;
  vec3 dir = direction_of_texel(id, float(size));
  vec3 east, north;
  tangents(dir, east, north);
  float texel = 1.6 / float(size);

  vec3 origin = textureLod(origin_tex, dir, 0.0).xyz;
  vec3 recent = textureLod(recent_tex, dir, 0.0).xyz;
  vec3 to_east = (textureLod(origin_tex, dir + texel * east, 0.0).xyz - textureLod(origin_tex, dir - texel * east, 0.0).xyz) / (2.0 * texel);
  vec3 to_north = (textureLod(origin_tex, dir + texel * north, 0.0).xyz - textureLod(origin_tex, dir - texel * north, 0.0).xyz) / (2.0 * texel);
  vec3 recent_east = (textureLod(recent_tex, dir + texel * east, 0.0).xyz - textureLod(recent_tex, dir - texel * east, 0.0).xyz) / (2.0 * texel);
  vec3 recent_north = (textureLod(recent_tex, dir + texel * north, 0.0).xyz - textureLod(recent_tex, dir - texel * north, 0.0).xyz) / (2.0 * texel);
  float nyquist = 0.5 / texel;
  float origin_finest = nyquist / max(sqrt(dot(to_east, to_east) + dot(to_north, to_north)), 1.0);
  float recent_finest = nyquist / max(sqrt(dot(recent_east, recent_east) + dot(recent_north, recent_north)), 1.0);

  // Air masses. Poleward: how far the air has come from the equator's side (it rises on the way), rad. Contrast: how
  // much of the origin's latitude is packed into a place: fronts.
  float cos_lat = max(length(dir.xy), 0.1);
  float side = clamp(dir.z * 6.0, -1.0, 1.0);
  float poleward = (dir.z - origin.z) * side / cos_lat;
  vec2 gradient = vec2(to_east.z, to_north.z) / cos_lat;
  float contrast = length(gradient);
  float front = smoothstep(1.6, 5.0, contrast);

  // Noises: `old` in the air's origin (drawn out along the flow), `young` hardly drawn out, with all scales.
  float old = fbm(origin, 4.0, 6, 0.62, origin_finest, seed + 11u);
  float streaks = fbm(origin * vec3(1.0, 1.0, 1.6) + 5.0, 9.0, 5, 0.70, origin_finest, seed + 23u);
  float young = fbm(recent, 7.0, 6, 0.66, recent_finest, seed + 37u);
  float wide = fbm(recent, 1.9, 3, 0.5, recent_finest, seed + 47u);
  float grain = fbm(dir, 26.0, 4, 0.75, nyquist, seed + 59u);
  float clusters = fbm(recent + 0.03 * vec3(young, streaks, -young), 6.5, 5, 0.62, recent_finest, seed + 71u);

  float lat = degrees(asin(clamp(dir.z + 0.035 * wide, -1.0, 1.0)));
  float a = abs(lat);
  float lon = atan(dir.y, dir.x);

  // The ITCZ wanders: north of the equator, further over the continents' side of the year, with a second branch over
  // the western Pacific and a diagonal one in the South Pacific.
  float itcz_lat = 6.0 + 2.5 * sin(lon * 2.0 + 0.6) + 3.0 * wide;
  float itcz = bump(lat, itcz_lat, 4.2);
  float warm_pool = exp(-2.2 * (1.0 - dot(dir, vec3(-0.81, 0.58, -0.03)))) * bump(lat, 0.0, 14.0);
  float spcz = bump(dot(dir, normalize(vec3(0.25, 0.55, 0.80))), 0.0, 0.09) * smoothstep(0.1, 0.7, dot(dir, normalize(vec3(-0.90, -0.30, -0.32))));
  float tropics = max(itcz, max(0.8 * warm_pool, 0.75 * spcz));
  float dry = bump(a, 22.0, 10.0) * (1.0 - 0.7 * tropics);
  float storm = bump(a, 53.0, 16.0);
  float polar = smoothstep(68.0, 85.0, a);

  // Warm air climbing polewards, cold air sinking behind it.
  float rising = smoothstep(0.015, 0.16, poleward) * smoothstep(12.0, 30.0, a);
  float sinking = smoothstep(0.01, 0.14, -poleward) * smoothstep(15.0, 32.0, a);
  float cold_front = front * smoothstep(-0.06, 0.03, poleward) * smoothstep(14.0, 26.0, a);

  // Tropical cyclones: a shield with arms, and a small clear eye.
  float shield = 0.0, eye = 0.0;
  for (uint i = 0u; i < kWeatherVortices; ++i) {
    WeatherVortex v = generate.generate_data.vortices[i];
    vec3 d = dir - v.centre;
    float q = dot(d, d) / (v.radius * v.radius);
    shield = max(shield, v.tropical * exp(-0.22 * q));
    eye = max(eye, v.tropical * exp(-16.0 * q));
  }

  // Stratocumulus west of the continents: decks with broken edges.
  float deck = 0.0;
  for (uint i = 0u; i < kWeatherDecks; ++i) {
    vec4 d = generate.generate_data.decks[i];
    vec3 off = dir - d.xyz;
    vec3 along = normalize(vec3(-d.y, d.x, 0.0));
    float x = dot(off, along) / 1.7, y = dot(off - along * dot(off, along), off - along * dot(off, along));
    deck = max(deck, 1.0 - sqrt(x * x + y) / d.w + 0.22 * young + 0.16 * old);
  }
  deck = smoothstep(0.0, 0.5, deck);

  float cells = 1.0 - worley_distance(recent * 21.0 + 0.25 * vec3(grain, young, streaks), kNoWrap, seed + 83u);

  float low = 0.55 * young + 0.45 * grain + 0.35 * old + 1.9 * deck * (0.75 + 0.5 * cells) + 0.55 * storm + 0.75 * sinking * (0.5 + cells) +
              0.55 * rising + 0.5 * polar - 0.75 * dry * (1.0 - deck) - 0.25 * tropics + 0.3 * bump(a, 13.0, 6.0) * grain;
  float middle = 0.50 * old + 0.35 * streaks + 0.45 * young + 1.9 * rising * (0.55 + 0.45 * front) + 0.9 * cold_front - 1.0 * sinking -
                 0.75 * dry + 0.35 * storm + 0.55 * tropics * (0.4 + 0.6 * clusters) + 2.2 * shield - 3.0 * eye - 0.4 * deck;
  float high = 0.30 * old + 0.60 * streaks + 0.35 * young + 1.9 * smoothstep(0.0, 0.22, poleward) * smoothstep(10.0, 26.0, a) - 0.9 * sinking -
               0.55 * dry + 0.9 * tropics * (0.5 + 0.8 * clusters) + 2.4 * shield - 3.0 * eye - 0.3 * polar;
  float deep = 1.5 * tropics * (0.45 + clusters) + 0.45 * clusters * bump(a, 5.0, 16.0) + 0.25 * young + 0.25 * grain + 1.1 * cold_front * (0.6 + 0.5 * streaks) +
               0.35 * rising * (young) - 1.0 * dry - 0.9 * smoothstep(48.0, 66.0, a) + 3.0 * shield * (0.7 + 0.4 * young) - 4.0 * eye;

  // Properties: type, base offset (m), density factor, precipitation.
  float towering = clamp(0.45 + 0.5 * tropics + 0.55 * cold_front + 0.3 * sinking * storm - 0.5 * deck - 0.45 * rising * (1.0 - front) - 0.35 * polar + 0.08 * young, 0.0, 1.0);
  float offset_m = 110.0 * wide + 60.0 * old - 120.0 * deck - 60.0 * storm + 60.0 * dry;
  float density = exp(0.13 * young + 0.06 * wide + 0.16 * deck - 0.10 * dry);
  float rain = smoothstep(1.0, 2.6, deep) + 0.6 * smoothstep(1.6, 3.2, middle) * (0.4 + 0.6 * front);
  imageStore(out_weather, ivec3(id), vec4(low, middle, high, deep));
  imageStore(out_properties, ivec3(id),
             vec4(towering, clamp(offset_m, -300.0, 300.0), clamp(density, 0.7, 1.4), clamp(rain, 0.0, 1.0)));
}
