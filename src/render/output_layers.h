#pragma once
#include <set>
#include <string>
#include <vector>

#include "gpu/types.h"
#include "io/image_buffer.h"
#include "render/camera_pose.h"

namespace nepho {

/// Images of a finished frame as they came from the GPU, row 0 on top.
struct FrameReadback {
  Extent2D extent;
  std::vector<float> radiance;    ///< RGBA, cd/m2
  std::vector<float> background;  ///< RGBA, cd/m2
  std::vector<float> depth_m;     ///< R
  std::vector<float> albedo;      ///< RGBA; a: 0 sky, 1 land, 2 water
  std::vector<float> cloud;       ///< RGBA: premultiplied radiance, transmittance
  std::vector<float> cloud_info;  ///< RGBA: depth_m, optical depth, layer, -
  std::vector<float> shadow;      ///< RG: share of the key light that clouds let through to the surface, and to what is
                                  ///< seen; of quality reference empty
  std::vector<float> variance;    ///< RGBA, of quality reference: variance of the pixel's mean; paths. Else empty
};

/// Names that `--aov` knows: channels ("depth.Z") and groups of them ("position").
const std::vector<std::string>& known_layers();

/// The layers of DESIGN.md, 'Images that mean something'. `wanted` empty: all. R, G, B are always there.
/// Positions: dx, dy, dz are the pixel's own ray times its depth, in double, narrowed once; degrees and height follow
/// from the narrowed values, so that they agree with each other to the rounding of the degrees.
ImageBuffer make_output_layers(const FrameReadback& frame, const CameraPose& pose, const std::set<std::string>& wanted);

}  // namespace nepho
