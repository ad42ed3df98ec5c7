// What every pass of a frame needs to know: camera, planet, sun, clock. One uniform block, scalar layout, bound as `frame`.
#ifndef NEPHO_COMMON_FRAME_H
#define NEPHO_COMMON_FRAME_H
#include "common/planet.h"
SHARED_BEGIN

struct FrameConstants {
  PlanetView planet;
  // Camera: ECEF axes, origin at the camera. A pixel centre's direction is forward + x right + y up (not normalised),
  // x = (2 (px + 0.5) / width - 1), y = (1 - 2 (py + 0.5) / height); right and up carry the tangents of half the field of view.
  vec3 forward;
  float pixel_angle_rad;      // angle of one pixel at the image centre
  vec3 right;
  float time_s;               // seconds since the scene's epoch, reduced; clouds' clock
  vec3 up;
  uint frame_index;           // seeds noise
  vec3 camera_up;             // geodetic normal at the camera, unit
  uint seed;
  vec3 sun_dir;               // unit, towards the sun, ECEF axes
  float sun_angular_radius_rad;
  vec3 sun_illuminance;       // on a facing plane at the top of the atmosphere, linear Rec. 709 whose luminance is in lux
  float sun_distance_factor;  // (1 au / distance)^2, already in sun_illuminance
  uvec2 size;                 // px
  vec2 jitter_px;             // sub-pixel offset of this frame's rays
  float near_m;               // reversed-Z infinite projection: depth = near / z
  uint light_count;           // 1: the sun alone lights the air; 2: the moon as well
  vec3 moon_dir;              // unit, from the camera towards the moon's centre (parallax included), ECEF axes
  float moon_angular_radius_rad;
  vec3 moon_share;            // moonlight at the top of the air per sunlight at 1 au, per channel
  float pad0;
  vec3 key_dir;               // unit, towards the light that casts shadows on clouds and ground: the sun, deep at night the moon
  float pad1;
  vec3 key_illuminance;       // of that light on a facing plane at the top of the air, lux per channel
  float pad2;
  vec3 sun_illuminance_1au;   // sun_illuminance / sun_distance_factor
  float pad3;
  vec3 night_illuminance;     // of airglow and stars on a horizontal plane at the ground, lux per channel: the least light there is
  float pad4;
};

// Unit direction through pixel coordinates (pixel centres at +0.5).
SHARED_FN vec3 pixel_direction(FrameConstants frame, vec2 pixel) {
  float x = 2.0f * (pixel.x + frame.jitter_px.x) / float(frame.size.x) - 1.0f;
  float y = 1.0f - 2.0f * (pixel.y + frame.jitter_px.y) / float(frame.size.y);
  return normalize(frame.forward + x * frame.right + y * frame.up);
}

// Distance along the pixel's ray from reversed-Z depth; kFarDepth_m for the cleared value 0.
SHARED_FN float distance_from_depth(FrameConstants frame, float depth, vec3 dir) {
  if (depth <= 0.0f) return kFarDepth_m;
  return (frame.near_m / depth) / dot(dir, frame.forward);
}

SHARED_END
#endif
