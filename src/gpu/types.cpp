#include "gpu/types.h"

namespace nepho {

uint32_t bytes_per_texel(Format format) {
  switch (format) {
    case Format::undefined:
      return 0;
    case Format::r8:
      return 1;
    case Format::rg8:
    case Format::r16:
    case Format::r16f:
      return 2;
    case Format::rgba8:
    case Format::rgba8_srgb:
    case Format::rg16:
    case Format::rg16_snorm:
    case Format::rg16f:
    case Format::r32f:
    case Format::r32u:
    case Format::d32f:
      return 4;
    case Format::rgba16:
    case Format::rgba16f:
    case Format::rg32f:
    case Format::rg32u:
      return 8;
    case Format::rgba32f:
    case Format::rgba32u:
      return 16;
  }
  return 0;
}

const char* name_of(Format format) {
  switch (format) {
    case Format::undefined:
      return "undefined";
    case Format::r8:
      return "r8";
    case Format::rg8:
      return "rg8";
    case Format::rgba8:
      return "rgba8";
    case Format::rgba8_srgb:
      return "rgba8_srgb";
    case Format::r16:
      return "r16";
    case Format::rg16:
      return "rg16";
    case Format::rgba16:
      return "rgba16";
    case Format::rg16_snorm:
      return "rg16_snorm";
    case Format::r16f:
      return "r16f";
    case Format::rg16f:
      return "rg16f";
    case Format::rgba16f:
      return "rgba16f";
    case Format::r32f:
      return "r32f";
    case Format::rg32f:
      return "rg32f";
    case Format::rgba32f:
      return "rgba32f";
    case Format::r32u:
      return "r32u";
    case Format::rg32u:
      return "rg32u";
    case Format::rgba32u:
      return "rgba32u";
    case Format::d32f:
      return "d32f";
  }
  return "?";
}

}  // namespace nepho
