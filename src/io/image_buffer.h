#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace nepho {

/// One named channel of a picture, row 0 on top: "R", "depth.Z", "cloud.transmittance".
struct ImageChannel {
  std::string name;
  std::vector<float> values;  ///< width * height
};

/// A picture in scene-linear units with named channels and header attributes, as an EXR holds it.
struct ImageBuffer {
  uint32_t width = 0, height = 0;
  std::vector<ImageChannel> channels;
  const ImageChannel* find(const std::string& name) const {
    for (const ImageChannel& c : channels)
      if (c.name == name) return &c;
    return nullptr;
  }
};

}  // namespace nepho
