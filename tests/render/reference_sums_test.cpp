#include "render/reference_sums.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

#include "base/error.h"

using namespace nepho;
using shared::PixelSums;

namespace {

struct Sample {
  glm::dvec3 light;
  bool cloud;
};

std::vector<Sample> draw(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> light(1.0 / 3000.0);
  std::uniform_real_distribution<double> tint(0.5, 1.5);
  std::vector<Sample> samples;
  for (size_t i = 0; i < count; ++i) {
    const double y = light(random);
    samples.push_back({{y * tint(random), y, y * tint(random)}, random() % 3 != 0});
  }
  return samples;
}

/// Two passes over the samples, in double.
PixelSums direct(const std::vector<Sample>& samples) {
  const glm::dvec3 weights(0.2126, 0.7152, 0.0722);
  const auto n = static_cast<double>(samples.size());
  glm::dvec3 mean(0.0), cloud(0.0), squares(0.0);
  double clear = 0.0, y_squares = 0.0;
  for (const Sample& s : samples) {
    mean += s.light / n;
    if (s.cloud) cloud += s.light / n;
    if (!s.cloud) clear += 1.0 / n;
  }
  for (const Sample& s : samples) {
    const glm::dvec3 d = s.light - mean;
    squares += d * d;
    y_squares += glm::dot(weights, d) * glm::dot(weights, d);
  }
  PixelSums sums{};
  sums.paths = static_cast<float>(n);
  sums.mean = glm::vec3(mean);
  sums.squares = glm::vec3(squares);
  sums.y_squares = static_cast<float>(y_squares);
  sums.cloud = glm::vec3(cloud);
  sums.transmittance = static_cast<float>(clear);
  sums.layers.y = static_cast<float>(std::lround((1.0 - clear) * n));
  sums.depth_m = 5000.0f * sums.layers.y;
  return sums;
}

void check_near(const PixelSums& a, const PixelSums& b, double epsilon) {
  const auto near = [&](float x, float y) { CHECK(x == doctest::Approx(y).epsilon(epsilon)); };
  near(a.paths, b.paths);
  for (int c = 0; c < 3; ++c) {
    near(a.mean[c], b.mean[c]);
    near(a.squares[c], b.squares[c]);
    near(a.cloud[c], b.cloud[c]);
  }
  near(a.y_squares, b.y_squares);
  near(a.transmittance, b.transmittance);
  near(a.depth_m, b.depth_m);
  for (int l = 0; l < 4; ++l) near(a.layers[l], b.layers[l]);
}

/// A picture with the layers that quality reference writes.
ImageBuffer picture_of(const std::vector<PixelSums>& sums, Extent2D extent) {
  FrameReadback frame;
  frame.extent = extent;
  put_sums(sums, frame);
  ImageBuffer image;
  image.width = extent.width;
  image.height = extent.height;
  const auto add = [&](const std::string& name, const std::vector<float>& rgba, size_t channel) {
    ImageChannel c;
    c.name = name;
    for (size_t i = 0; i < sums.size(); ++i) c.values.push_back(rgba[4 * i + channel]);
    image.channels.push_back(c);
  };
  const char* const rgb[] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c) {
    add(rgb[c], frame.radiance, c);
    add(std::string("variance.") + rgb[c], frame.variance, c);
    add(std::string("cloud.") + rgb[c], frame.cloud, c);
  }
  add("samples", frame.variance, 3);
  add("cloud.transmittance", frame.cloud, 3);
  add("cloud.depth_m", frame.cloud_info, 0);
  add("cloud.layer", frame.cloud_info, 2);
  return image;
}

}  // namespace

TEST_CASE("merged sums are those of all paths together") {
  for (const auto& [first, second] :
       {std::pair<size_t, size_t>{1, 1}, {2, 500}, {500, 3}, {400, 400}, {7, 0}, {0, 9}}) {
    CAPTURE(first);
    CAPTURE(second);
    const std::vector<Sample> a = draw(first, 11), b = draw(second, 22);
    std::vector<Sample> both = a;
    both.insert(both.end(), b.begin(), b.end());
    const auto sums = [](const std::vector<Sample>& s) { return s.empty() ? PixelSums{} : direct(s); };
    check_near(merged({sums(a)}, {sums(b)}).front(), direct(both), 3e-6);
  }
  CHECK(merged({PixelSums{}}, {PixelSums{}}).front().paths == 0.0f);
}

TEST_CASE("the noise of a picture is what 95 of 100 pixels have at most; black ones have none") {
  const auto pixel = [](float relative_error) {  // of the mean of 25 paths
    PixelSums s{};
    s.paths = 25.0f;
    s.mean = glm::vec3(2.0f);
    s.y_squares = std::pow(2.0f * relative_error, 2.0f) * 25.0f * 24.0f;
    return s;
  };
  std::vector<PixelSums> sums;
  for (int i = 0; i < 100; ++i) sums.push_back(pixel(0.001f * static_cast<float>((i * 37) % 100)));
  CHECK(noise_of(sums) == doctest::Approx(0.095).epsilon(1e-4));
  for (int i = 0; i < 100; ++i) {
    PixelSums black{};
    black.paths = 25.0f;
    sums.push_back(black);
  }
  CHECK(noise_of(sums) == doctest::Approx(0.090).epsilon(1e-4));
  for (PixelSums& s : sums) s.paths = 1.0f;
  CHECK(noise_of(sums) == 1.0);
  CHECK(noise_of({}) == 1.0);
}

TEST_CASE("sums that were written as a picture come back from it") {
  std::vector<PixelSums> sums;
  for (uint32_t i = 0; i < 6; ++i) {
    std::vector<Sample> grey = draw(2 + 100 * i, 40 + i);
    // One colour: only its luminance's variance is known exactly from the three channels'.
    for (Sample& s : grey) s.light = s.light.g * glm::dvec3(1.2, 1.0, 0.8);
    sums.push_back(direct(grey));
  }
  PixelSums clear = direct({{glm::dvec3(5.0), false}, {glm::dvec3(7.0), false}});
  sums[5] = clear;
  const std::vector<PixelSums> back = sums_of_picture(picture_of(sums, {3, 2}), {3, 2});
  REQUIRE(back.size() == 6);
  for (size_t i = 0; i < 6; ++i) {
    CAPTURE(i);
    check_near(back[i], sums[i], 1e-5);
  }
  CHECK(noise_of(back) == doctest::Approx(noise_of(sums)).epsilon(1e-5));
}

TEST_CASE("a picture of another size or without its layers cannot be gone on with, and the error says why") {
  const std::vector<PixelSums> sums(6, direct(draw(10, 1)));
  const ImageBuffer picture = picture_of(sums, {3, 2});
  const auto message = [](const ImageBuffer& image, Extent2D extent) -> std::string {
    try {
      sums_of_picture(image, extent);
    } catch (const Error& error) {
      CHECK(error.kind() == ErrorKind::input);
      return error.what();
    }
    return "";
  };
  CHECK(message(picture, {3, 2}).empty());
  CHECK(message(picture, {2, 3}).find("3x2") != std::string::npos);
  CHECK(message(picture, {2, 3}).find("2x3") != std::string::npos);
  for (size_t i = 0; i < picture.channels.size(); ++i) {
    ImageBuffer less = picture;
    const std::string name = less.channels[i].name;
    less.channels.erase(less.channels.begin() + static_cast<std::ptrdiff_t>(i));
    CHECK_MESSAGE(message(less, {3, 2}).find("'" + name + "'") != std::string::npos, name);
  }
}
