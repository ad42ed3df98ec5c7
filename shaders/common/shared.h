// Glue that lets one header serve both C++ and GLSL. In C++ the contents live in nepho::shared with the GLM names.
#ifndef NEPHO_COMMON_SHARED_H
#define NEPHO_COMMON_SHARED_H

#ifdef __cplusplus
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#define SHARED_BEGIN        \
  namespace nepho::shared { \
  using namespace glm;      \
  using uint = uint32_t;
#define SHARED_END }
#define SHARED_FN inline
#define SHARED_OUT(T) T&
#define SHARED_INOUT(T) T&
#define SHARED_CONST inline constexpr
#else
#extension GL_EXT_scalar_block_layout : require
#define SHARED_BEGIN
#define SHARED_END
#define SHARED_FN
#define SHARED_OUT(T) out T
#define SHARED_INOUT(T) inout T
#define SHARED_CONST const
#endif

SHARED_BEGIN
SHARED_CONST float kPi = 3.14159265358979f;
SHARED_CONST float kFarDepth_m = 1.0e10f;  // depth.Z of the sky
SHARED_END

#endif
