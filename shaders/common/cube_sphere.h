// The cube around the sphere: how a direction becomes a face and a place on it (docs/units_and_frames.md, 'Cube
// sphere').
//
// Faces are numbered and turned as Vulkan's cube maps are (+X, -X, +Y, -Y, +Z, -Z; Vulkan 1.3, 16.5.4), and (u, v) is
// the gnomonic coordinate that a samplerCube computes, so that texel (i, j) of face f has its centre in
// direction_from_cube(f, (i + 0.5, j + 0.5) / N), and hardware filters across edges and corners without a seam. Seen
// from outside, u runs right and v down on every face: none is mirrored.
//
// Gnomonic texels differ 5.2-fold in solid angle; with the tangent warp on top only 1.41-fold. The warp keeps face
// edges and is the same along both faces of an edge, so a warped map is read seamlessly by
// texture(map, cube_warped_direction(dir)). Its polynomials (1.4e-7 of a face) stand in for atan and tan because Vulkan
// lets those be off by 4096 units in the last place, a different amount on every device.
#ifndef NEPHO_COMMON_CUBE_SPHERE_H
#define NEPHO_COMMON_CUBE_SPHERE_H
#include "common/shared.h"
SHARED_BEGIN

struct CubePoint {
  uint face;  // 0..5: +X, -X, +Y, -Y, +Z, -Z
  vec2 uv;    // 0..1 each, exactly 0 or 1 on edges
};

// Face and (u, v) of a direction of any length but 0. Where components are equal in magnitude, z goes before y before
// x.
SHARED_FN CubePoint cube_from_direction(vec3 dir) {
  vec3 m = abs(dir);
  CubePoint p;
  vec3 c;  // s and t along the face, and the major axis
  if (m.z >= m.x && m.z >= m.y) {
    p.face = dir.z >= 0.0f ? 4u : 5u;
    c = vec3(dir.z >= 0.0f ? dir.x : -dir.x, -dir.y, m.z);
  } else if (m.y >= m.x) {
    p.face = dir.y >= 0.0f ? 2u : 3u;
    c = vec3(dir.x, dir.y >= 0.0f ? dir.z : -dir.z, m.y);
  } else {
    p.face = dir.x >= 0.0f ? 0u : 1u;
    c = vec3(dir.x >= 0.0f ? -dir.z : dir.z, -dir.y, m.x);
  }
  p.uv = vec2(0.5f * (c.x / c.z + 1.0f), 0.5f * (c.y / c.z + 1.0f));
  return p;
}

// The point of the cube [-1, 1]^3 at (u, v) of a face: not normalised.
SHARED_FN vec3 cube_surface_point(uint face, vec2 uv) {
  float s = 2.0f * uv.x - 1.0f;
  float t = 2.0f * uv.y - 1.0f;
  float major = (face & 1u) == 0u ? 1.0f : -1.0f;
  uint axis = face >> 1u;
  if (axis == 0u) return vec3(major, -t, -major * s);
  if (axis == 1u) return vec3(s, major, major * t);
  return vec3(major * s, -t, major);
}

// Unit direction at (u, v) of a face.
SHARED_FN vec3 direction_from_cube(uint face, vec2 uv) { return normalize(cube_surface_point(face, uv)); }

// Solid angle per unit of u v area, sr: 4 / (1 + s^2 + t^2)^(3/2), which integrates to 4 pi / 6 over a face.
SHARED_FN float cube_solid_angle_density(vec2 uv) {
  float s = 2.0f * uv.x - 1.0f;
  float t = 2.0f * uv.y - 1.0f;
  float r2 = 1.0f + s * s + t * t;
  return 4.0f / (r2 * sqrt(r2));
}

// 4/pi atan(x) on [-1, 1]: exact at -1, 0 and 1.
SHARED_FN float cube_warp(float x) {
  float z = x * x;
  float q =
      0.273239093f +
      z * (-0.151129021f +
           z * (0.102728101f + z * (-0.0735261055f + z * (0.0466871643f + z * (-0.0206893353f + z * 0.00438045947f)))));
  return x + x * ((1.0f - z) * q);
}

// tan(pi/4 x) on [-1, 1]: the inverse of cube_warp.
SHARED_FN float cube_unwarp(float x) {
  float z = x * x;
  float q = -0.214601778f +
            z * (-0.0531149832f +
                 z * (-0.0132167106f + z * (-0.00351217099f + z * (-0.000476221867f + z * -0.000476220701f))));
  return x + x * ((1.0f - z) * q);
}

// Tangent-warped (u, v) of a gnomonic one, and back.
SHARED_FN vec2 cube_warp_uv(vec2 uv) {
  return vec2(0.5f * (cube_warp(2.0f * uv.x - 1.0f) + 1.0f), 0.5f * (cube_warp(2.0f * uv.y - 1.0f) + 1.0f));
}
SHARED_FN vec2 cube_unwarp_uv(vec2 uv) {
  return vec2(0.5f * (cube_unwarp(2.0f * uv.x - 1.0f) + 1.0f), 0.5f * (cube_unwarp(2.0f * uv.y - 1.0f) + 1.0f));
}

// The direction to hand to a samplerCube whose texels are laid out by the tangent warp: the sampler's own gnomonic
// (u, v) of it is the warped (u, v) of `dir`. Length between 1 and sqrt(3).
SHARED_FN vec3 cube_warped_direction(vec3 dir) {
  vec3 c = dir / max(max(abs(dir.x), abs(dir.y)), abs(dir.z));
  return vec3(cube_warp(c.x), cube_warp(c.y), cube_warp(c.z));
}

SHARED_END
#endif
