#version 460
#extension GL_GOOGLE_include_directive : require
// The large-scale weather: four numbers per direction, higher is cloudier (low, middle, high clouds, deep convection),
// which the CPU turns into ranks (weather_generator.cpp), and the properties. docs/weather.md has the reasoning.
// Everything is a function of the place on the sphere, so cube edges, poles and the antimeridian cannot show.
#include "weather/weather_generate.glsl"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 1) uniform samplerCube origin_tex;
layout(set = 0, binding = 2) uniform samplerCube recent_tex;
layout(set = 0, binding = 3) uniform sampler3D noise_tex;
layout(set = 0, binding = 4, rgba32f) uniform writeonly image2DArray out_weather;
layout(set = 0, binding = 5, rgba32f) uniform writeonly image2DArray out_properties;

float bump(float x, float centre, float width) {
  float t = (x - centre) / width;
  return exp(-t * t);
}

// Octave i of the noise at p, `frequency` cycles per unit; what the texels cannot hold (`finest`) fades.
vec4 octave(vec3 p, float frequency, float finest, int i) {
  float turn = 1.1 * float(i) + 0.4;
  vec3 q = vec3(cos(turn) * p.x + sin(turn) * p.y, cos(turn) * p.y - sin(turn) * p.x, p.z);  // no shared lattice
  q = vec3(q.x, 0.8 * q.y + 0.6 * q.z, 0.8 * q.z - 0.6 * q.y);
  vec4 n = textureLod(noise_tex, q * (frequency / 16.0) + 0.37 * float(i + 1), 0.0);
  return n * (1.0 - smoothstep(0.6, 1.4, frequency / finest));
}

// Cycles per unit that texels hold where the air from around `dir` was packed together by the flow.
float finest_left(vec3 to_east, vec3 to_north, float nyquist) {
  return nyquist / max(sqrt(0.5 * (dot(to_east, to_east) + dot(to_north, to_north))), 1.0);
}

void main() {
  uvec3 id = gl_GlobalInvocationID;
  uint size = generate.generate_data.size;
  if (id.x >= size || id.y >= size) return;
  vec3 dir = direction_of_texel(id, float(size));
  vec3 east, north;
  tangents(dir, east, north);

  vec3 origin = textureLod(origin_tex, dir, 0.0).xyz;
  vec3 recent = textureLod(recent_tex, dir, 0.0).xyz;
  float e = 1.6 / float(textureSize(origin_tex, 0).x);
  vec3 to_east = (textureLod(origin_tex, dir + e * east, 0.0).xyz - textureLod(origin_tex, dir - e * east, 0.0).xyz) / (2.0 * e);
  vec3 to_north = (textureLod(origin_tex, dir + e * north, 0.0).xyz - textureLod(origin_tex, dir - e * north, 0.0).xyz) / (2.0 * e);
  float nyquist = 0.25 * float(size);
  float origin_finest = finest_left(to_east, to_north, nyquist);
  float recent_finest = mix(nyquist, origin_finest, 0.4);

  // Noises in the air's origin, drawn out along the flow: `old` with all scales, `streaks` fine.
  float old = 0.0, streaks = 0.0;
  float frequency = 4.0;
  for (int i = 0; i < 6; ++i) {
    vec4 n = octave(origin, frequency, origin_finest, i);
    old += n.x * pow(0.66, float(i));
    streaks += n.y * (i == 0 ? 0.3 : pow(0.80, float(i)));
    frequency *= 2.03;
  }
  old *= 0.77;
  streaks *= 0.70;
  // Noises hardly drawn out: `wide` of continents, `young` of all scales, `clusters` of some 500 km, `grain` fine.
  float wide = 0.0, young = 0.0, clusters = 0.0, grain = 0.0, cells = 0.0;
  frequency = 1.9;
  for (int i = 0; i < 7; ++i) {
    vec4 n = octave(recent, frequency, recent_finest, i + 9);
    wide += n.x * exp(-0.9 * float(i * i));
    young += n.y * (i == 0 ? 0.45 : pow(0.80, float(i)));
    clusters += n.z * exp(-0.20 * (float(i) - 2.6) * (float(i) - 2.6));
    grain += n.x * smoothstep(2.5, 4.5, float(i));
    cells += n.w * (i == 4 ? 0.6 : i == 5 ? 0.4 : 0.0);
    frequency *= 2.03;
  }
  wide *= 0.92;
  young *= 0.62;
  clusters *= 0.52;
  grain *= 0.65;

  // Air masses. Poleward: how far the air has come from the equator's side (it rises on the way), rad. Contrast: how
  // much of the origin's latitude is packed into a place: fronts.
  float cos_lat = max(length(dir.xy), 0.15);
  float side = clamp(dir.z * 6.0, -1.0, 1.0);
  float ragged = 0.016 * young + 0.010 * streaks;
  float poleward = (dir.z - origin.z) * side / cos_lat + ragged;
  float contrast = length(vec2(to_east.z, to_north.z)) / cos_lat;
  float front = smoothstep(1.5, 4.5, contrast + 0.35 * young);

  float lat = degrees(asin(clamp(dir.z + 0.035 * wide + 0.012 * young, -1.0, 1.0)));
  float a = abs(lat);
  float lon = atan(dir.y, dir.x);

  // The ITCZ wanders north of the equator; the western Pacific's warm pool widens it, and a branch leads from there
  // into the South Pacific.
  float itcz = bump(lat, 6.0 + 2.0 * sin(lon * 2.0 + 0.6) + 3.5 * wide + 0.8 * young, 3.6);
  float warm_pool = exp(-2.2 * (1.0 - dot(dir, vec3(-0.81, 0.58, -0.03)))) * bump(lat, 0.0, 13.0);
  float branch = bump(dot(dir, vec3(0.249, 0.549, 0.798)), 0.0, 0.08) * smoothstep(0.1, 0.7, dot(dir, vec3(-0.897, -0.299, -0.319)));
  float africa = exp(-5.0 * (1.0 - dot(dir, vec3(0.93, 0.36, 0.0)))) * bump(lat, 1.0, 9.0);
  float amazon = exp(-6.0 * (1.0 - dot(dir, vec3(0.45, -0.89, -0.07)))) * bump(lat, -4.0, 10.0);
  float tropics = max(max(itcz, 0.75 * warm_pool), max(0.7 * branch, 0.7 * max(africa, amazon)));
  float dry = bump(a, 22.0, 10.0) * (1.0 - 0.75 * tropics);
  float storm = bump(a, 54.0, 15.0);
  float polar = smoothstep(66.0, 82.0, a);

  // Warm air climbing polewards, cold air sinking behind it.
  float outside = smoothstep(13.0, 30.0, a);
  float climb = poleward + 0.03 * old;
  float rising = smoothstep(0.04, 0.22, climb) * outside * (1.0 - 0.6 * polar);
  float sinking = smoothstep(0.01, 0.13, -poleward) * outside;
  float cold_front = front * bump(poleward, 0.035, 0.05 + e * max(contrast - 2.0, 0.0)) * smoothstep(15.0, 27.0, a) * (1.0 - polar);

  // Tropical cyclones: a shield with arms, and a small clear eye.
  float shield = 0.0, eye = 0.0;
  for (uint i = 0u; i < kWeatherVortices; ++i) {
    WeatherVortex v = generate.generate_data.vortices[i];
    vec3 d = dir - v.centre;
    float q = dot(d, d) / (v.radius * v.radius);
    shield = max(shield, v.tropical * exp(-0.16 * q));
    eye = max(eye, v.tropical * exp(-18.0 * q));
  }

  // Stratocumulus west of the continents: decks with broken edges.
  float deck = 0.0;
  for (uint i = 0u; i < kWeatherDecks; ++i) {
    vec4 d = generate.generate_data.decks[i];
    vec3 off = dir - d.xyz;
    vec3 along = vec3(-d.y, d.x, 0.0) * inversesqrt(d.x * d.x + d.y * d.y);
    float x = dot(off, along);
    float y2 = dot(off, off) - x * x;
    deck = max(deck, 1.0 - sqrt(0.3 * x * x + y2) / d.w + 0.26 * young + 0.24 * old);
  }
  deck = smoothstep(-0.1, 0.9, deck);

  float trades = bump(a, 14.0, 8.0) * (1.0 - tropics);
  float low = 0.40 * young + 0.25 * old + (0.35 + 0.55 * trades + 0.5 * sinking) * (0.8 * grain + 0.7 * (cells - 0.5) + 0.35 * old) +
              deck * (1.5 + 0.9 * (cells - 0.5) + 0.4 * streaks) + 0.5 * storm + 0.65 * sinking * storm + 0.45 * rising + 0.35 * polar - 0.7 * dry * (1.0 - deck) -
              0.2 * tropics + 0.2 * wide;
  float middle = 0.42 * old + 0.38 * streaks + 0.40 * young + 0.15 * grain + rising * (0.55 + 0.8 * front + 0.45 * streaks) + 1.1 * cold_front - 0.9 * sinking -
                 0.65 * dry + 0.40 * storm + 0.5 * tropics * (0.5 + 0.9 * clusters) + 2.2 * shield * (0.8 + 0.5 * streaks) - 3.0 * eye -
                 0.4 * deck;
  float high = 0.35 * old + 0.60 * streaks + 0.25 * young + outside * (1.1 + 0.35 * streaks) * smoothstep(0.0, 0.24, climb) * (1.0 - 0.6 * polar) + 0.4 * cold_front -
               0.9 * sinking - 0.45 * dry + tropics * (0.35 + 0.9 * clusters) + 2.4 * shield - 3.0 * eye - 0.3 * polar;
  float deep = tropics * (0.55 + 1.5 * clusters + 0.4 * young) + 0.30 * clusters * bump(a, 5.0, 18.0) + 0.22 * young + 0.20 * grain +
               cold_front * (0.75 + 0.5 * streaks) - 0.8 * dry - 0.9 * smoothstep(46.0, 64.0, a) + 2.6 * shield * (0.7 + 0.5 * streaks) - 4.0 * eye;

  // Properties: type, base offset (m), density factor, precipitation.
  float type = 0.45 + tropics * (0.3 + 0.25 * clusters) + 0.55 * cold_front + 0.25 * sinking * storm - 0.5 * deck - 0.45 * rising * (1.0 - front) - 0.35 * polar +
               0.08 * young;
  float offset_m = 90.0 * wide + 45.0 * young - 120.0 * deck - 60.0 * storm + 60.0 * dry;
  float density = exp(0.13 * young + 0.06 * wide + 0.16 * deck - 0.10 * dry);
  float rain = smoothstep(1.0, 2.4, deep) + 0.6 * smoothstep(1.3, 2.8, middle) * (0.4 + 0.6 * front);
  imageStore(out_weather, ivec3(id), vec4(low, middle, high, deep));
  imageStore(out_properties, ivec3(id),
             vec4(clamp(type, 0.0, 1.0), clamp(offset_m, -250.0, 250.0), clamp(density, 0.7, 1.4), clamp(rain, 0.0, 1.0)));
}
