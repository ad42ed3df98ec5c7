#include "render/reference_sums.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "common/gamut.h"
#include "common/tonemap.h"

namespace nepho {

using shared::PixelSums;

namespace {

/// Variance of the mean from a sum of squared differences; of one path nothing is known: as much as the value itself.
float variance_of_mean(float squares, float mean, float paths) {
  return paths > 1.0f ? squares / (paths * (paths - 1.0f)) : mean * mean;
}

}  // namespace

double noise_of(const std::vector<PixelSums>& sums) {
  if (sums.empty() || sums.front().paths < 2.0f) return 1.0;
  std::vector<float> relative;
  relative.reserve(sums.size());
  for (const PixelSums& s : sums) {
    const float y = shared::luminance(s.mean);
    const float error = std::sqrt(std::max(variance_of_mean(s.y_squares, y, s.paths), 0.0f));
    relative.push_back(error > 0.0f ? error / std::max(std::abs(y), 1e-30f) : 0.0f);
  }
  const size_t at = std::min(relative.size() - 1, static_cast<size_t>(0.95 * static_cast<double>(relative.size())));
  std::nth_element(relative.begin(), relative.begin() + static_cast<std::ptrdiff_t>(at), relative.end());
  return static_cast<double>(relative[at]);
}

std::vector<PixelSums> merged(const std::vector<PixelSums>& a, const std::vector<PixelSums>& b) {
  std::vector<PixelSums> out = a;
  for (size_t i = 0; i < out.size(); ++i) {
    PixelSums& s = out[i];
    const PixelSums& t = b[i];
    const double n = static_cast<double>(s.paths) + static_cast<double>(t.paths);
    if (n <= 0.0) continue;
    const double share = static_cast<double>(t.paths) / n, cross = static_cast<double>(s.paths) * share;
    const glm::dvec3 apart = glm::dvec3(t.mean) - glm::dvec3(s.mean);
    const double y_apart = glm::dot(apart, glm::dvec3(0.2126, 0.7152, 0.0722));
    s.squares = glm::vec3(glm::dvec3(s.squares) + glm::dvec3(t.squares) + apart * apart * cross);
    s.y_squares = static_cast<float>(static_cast<double>(s.y_squares) + static_cast<double>(t.y_squares) +
                                     y_apart * y_apart * cross);
    s.mean = glm::vec3(glm::dvec3(s.mean) + apart * share);
    s.cloud = glm::vec3(glm::dvec3(s.cloud) + (glm::dvec3(t.cloud) - glm::dvec3(s.cloud)) * share);
    s.transmittance += static_cast<float>(share) * (t.transmittance - s.transmittance);
    s.depth_m += t.depth_m;
    s.layers += t.layers;
    s.paths = static_cast<float>(n);
  }
  return out;
}

std::vector<PixelSums> sums_of_picture(const ImageBuffer& picture, Extent2D extent) {
  if (picture.width != extent.width || picture.height != extent.height)
    throw fail(ErrorKind::input, "it is {}x{}; the picture to go on with is {}x{}", picture.width, picture.height,
               extent.width, extent.height);
  const auto layer = [&](const char* name) -> const std::vector<float>& {
    const ImageChannel* channel = picture.find(name);
    if (!channel)
      throw fail(ErrorKind::input,
                 "layer '{}' is missing; only a picture of --quality reference with all its layers "
                 "(no --aov) can be gone on with",
                 name);
    return channel->values;
  };
  const std::vector<float>*mean[3] = {&layer("R"), &layer("G"), &layer("B")},
        *variance[3] = {&layer("variance.R"), &layer("variance.G"), &layer("variance.B")},
        *cloud[3] = {&layer("cloud.R"), &layer("cloud.G"), &layer("cloud.B")};
  const std::vector<float>&paths = layer("samples"), &through = layer("cloud.transmittance"),
        &depth = layer("cloud.depth_m"), &dominant = layer("cloud.layer");
  constexpr float kWeights[] = {0.2126f, 0.7152f, 0.0722f};
  std::vector<PixelSums> sums(paths.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    PixelSums& s = sums[i];
    s.paths = paths[i];
    float y_error = 0.0f;
    for (int c = 0; c < 3; ++c) {
      s.mean[c] = (*mean[c])[i];
      s.cloud[c] = (*cloud[c])[i];
      s.squares[c] = (*variance[c])[i] * s.paths * std::max(s.paths - 1.0f, 0.0f);
      y_error += kWeights[c] * std::sqrt(s.squares[c]);  // the channels of a path are one but for their weights
    }
    s.y_squares = y_error * y_error;
    s.transmittance = through[i];
    const float met = std::round((1.0f - s.transmittance) * s.paths);
    if (depth[i] < 0.5f * shared::kFarDepth_m && met > 0.0f) {
      s.depth_m = depth[i] * met;
      const int slot = std::clamp(static_cast<int>(dominant[i]) - 1, 0, 3);
      s.layers[slot] = met;
    }
  }
  return sums;
}

void put_sums(const std::vector<PixelSums>& sums, FrameReadback& to) {
  to.radiance.resize(4 * sums.size());
  to.cloud.resize(4 * sums.size());
  to.cloud_info.resize(4 * sums.size());
  to.variance.resize(4 * sums.size());
  for (size_t i = 0; i < sums.size(); ++i) {
    const PixelSums& s = sums[i];
    const glm::vec3 mean = shared::within_rec709(s.mean);
    const float met = s.layers.x + s.layers.y + s.layers.z + s.layers.w;
    for (int c = 0; c < 3; ++c) {
      const size_t at = 4 * i + static_cast<size_t>(c);
      to.radiance[at] = mean[c];
      to.cloud[at] = s.cloud[c];
      to.variance[at] = std::max(variance_of_mean(s.squares[c], s.mean[c], s.paths), 0.0f);
    }
    const float through = std::clamp(s.transmittance, 0.0f, 1.0f);
    to.radiance[4 * i + 3] = 1.0f;
    to.cloud[4 * i + 3] = through;
    to.variance[4 * i + 3] = s.paths;
    int dominant = 0;
    for (int l = 1; l < 4; ++l)
      if (s.layers[l] > s.layers[dominant]) dominant = l;
    to.cloud_info[4 * i] = met > 0.0f ? s.depth_m / met : shared::kFarDepth_m;
    to.cloud_info[4 * i + 1] = -std::log(std::max(through, 1.1e-7f));
    to.cloud_info[4 * i + 2] = met > 0.0f ? static_cast<float>(dominant + 1) : 0.0f;
    to.cloud_info[4 * i + 3] = 0.0f;
  }
}

}  // namespace nepho
