#include "clouds/cloud_noise.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>

#include "base/files.h"
#include "clouds/clouds_shared.h"
#include "clouds/noise_recipe.h"
#include "gpu/gpu_fixture.h"
#include "io/file_test_tools.h"

using namespace nepho;

namespace {

const CloudNoise& built_in(gpu::Device& device) {
  static const CloudNoise noise(device);
  return noise;
}

/// One channel of mip 0 in standard deviations.
std::vector<float> channel_of(gpu::Device& device, const gpu::Image& image, size_t channel) {
  const std::vector<std::byte> bytes = device.download(image);
  const Format format = image.desc().format;
  const size_t width = format == Format::rgba16 || format == Format::rg16 || format == Format::r16 ? 2 : 1;
  const size_t stride = bytes_per_texel(image.desc().format);
  std::vector<float> values(bytes.size() / stride);
  for (size_t i = 0; i < values.size(); ++i) {
    const std::byte* at = &bytes[i * stride + channel * width];
    uint16_t word = 0;
    std::memcpy(&word, at, 2 * (width == 2));
    const float unit = width == 2 ? static_cast<float>(word) / 65535.0f : static_cast<float>(*at) / 255.0f;
    values[i] = (unit - 0.5f) * 2.0f * MippedVolume::kRange;
  }
  return values;
}

double mean_of(const std::vector<float>& values, double power = 1.0) {
  double sum = 0.0;
  for (const float v : values) sum += power == 1.0 ? v : std::pow(v, power);
  return sum / static_cast<double>(values.size());
}

double share_above(const std::vector<float>& values, float level) {
  const auto above = std::count_if(values.begin(), values.end(), [&](float v) { return v > level; });
  return static_cast<double>(above) / static_cast<double>(values.size());
}

double normal_share_above(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

double correlation(const std::vector<float>& a, const std::vector<float>& b) {
  double product = 0.0;
  for (size_t i = 0; i < a.size(); ++i) product += static_cast<double>(a[i]) * b[i];
  return product / static_cast<double>(a.size());
}

/// Mean square difference of neighbours along an axis: across the edge of the volume, and everywhere else.
struct Steps {
  double edge = 0.0, inner = 0.0;
};
Steps steps_of(const std::vector<float>& values, size_t size, size_t axis) {
  const size_t stride = axis == 0 ? 1 : axis == 1 ? size : size * size;
  Steps steps;
  for (size_t i = 0; i < values.size(); ++i) {
    const size_t at = i / stride % size;
    const size_t next = at + 1 < size ? i + stride : i - at * stride;
    const double d = values[next] - values[i];
    (at + 1 < size ? steps.inner : steps.edge) += d * d;
  }
  const double slice = static_cast<double>(size) * static_cast<double>(size);
  steps.edge /= slice;
  steps.inner /= slice * static_cast<double>(size - 1);
  return steps;
}

struct Channel {
  const char* name;
  const gpu::Image& image;
  size_t channel, size;
};
std::vector<Channel> channels_of(const CloudNoise& noise) {
  return {{"field r", noise.field(), 0, 128},
          {"field g", noise.field(), 1, 128},
          {"field b", noise.field(), 2, 128},
          {"field a", noise.field(), 3, 128},
          {"cells r", noise.cells(), 0, 128},
          {"cells g", noise.cells(), 1, 128},
          {"shape", noise.shape(), 0, 128},
          {"detail", noise.detail(), 0, 32},
          {"turbulence x", noise.turbulence(), 0, 64},
          {"turbulence y", noise.turbulence(), 1, 64},
          {"turbulence z", noise.turbulence(), 2, 64}};
}

}  // namespace

TEST_CASE("volume tools: probit inverts the normal distribution function") {
  CHECK(probit(0.5) == 0.0);
  CHECK(probit(0.975) == doctest::Approx(1.959963984540054).epsilon(1e-14));  // the textbooks' 1.96
  for (const double share : {1e-12, 1e-6, 0.001, 0.02, 0.07, 0.08, 0.3, 0.6, 0.93, 0.999, 1.0 - 1e-9})
    CHECK(0.5 * std::erfc(-probit(share) / std::numbers::sqrt2) == doctest::Approx(share).epsilon(1e-12));
}

TEST_CASE("volume tools: ranks make any values normal, in their order, equal ones equal") {
  std::vector<float> values;
  for (int i = 0; i < 4096; ++i) values.push_back(static_cast<float>(std::pow((i * 1237 % 4096) - 1000, 3)));
  const std::vector<float> before = values;
  REQUIRE(normalise_volume(values, true));
  CHECK(mean_of(values) == doctest::Approx(0.0).epsilon(1e-5));
  CHECK(mean_of(values, 2) == doctest::Approx(1.0).epsilon(1e-5));
  CHECK(share_above(values, 1.0f) == doctest::Approx(normal_share_above(1.0)).epsilon(0.01));
  for (size_t i = 1; i < values.size(); ++i) CHECK((values[i] > values[i - 1]) == (before[i] > before[i - 1]));

  std::vector<float> two(8, 1.0f);
  two[3] = two[5] = 2.0f;  // a quarter: 3, -1 / 3 by ranks, scaled to variance 1
  REQUIRE(normalise_volume(two, true));
  CHECK(two[3] == two[5]);
  CHECK(two[3] == doctest::Approx(std::sqrt(3.0)));
  CHECK(two[0] == doctest::Approx(-std::sqrt(1.0 / 3.0)));

  std::vector<float> flat(8, 1.5f);
  CHECK_FALSE(normalise_volume(flat, true));
  CHECK_FALSE(normalise_volume(flat, false));
  CHECK(flat == std::vector<float>(8, 1.5f));
}

TEST_CASE("volume tools: planes that are alike become independent") {
  std::vector<std::vector<float>> planes(3);
  for (int i = 0; i < 1000; ++i) {
    const auto a = static_cast<float>(i % 10), b = static_cast<float>(i / 10 % 10), c = static_cast<float>(i / 100);
    planes[0].push_back(a);
    planes[1].push_back(b + 0.3f * a);
    planes[2].push_back(c - 0.2f * a + 0.5f * b);
  }
  decorrelate(planes);
  const double deviation = std::sqrt(99.0 / 12.0);  // of 0..9
  for (size_t i = 0; i < 1000; ++i) {
    CHECK(planes[0][i] == doctest::Approx((static_cast<double>(i % 10) - 4.5) / deviation));
    CHECK(planes[1][i] == doctest::Approx((static_cast<double>(i / 10 % 10) - 4.5) / deviation));
    CHECK(planes[2][i] == doctest::Approx((static_cast<double>(i / 100) - 4.5) / deviation));
  }
}

TEST_CASE("volume tools: a mip is the mean of eight texels, and keeps what variance it has between its texels") {
  std::vector<float> values(64);
  for (size_t i = 0; i < 64; ++i) values[i] = static_cast<float>(i);
  const std::vector<float> half = half_volume(values, 4);
  REQUIRE(half.size() == 8);
  CHECK(half[0] == doctest::Approx((0 + 1 + 4 + 5 + 16 + 17 + 20 + 21) / 8.0));
  CHECK(half[7] - half[0] == doctest::Approx(2 + 8 + 32));

  // +-1 in turn along x: linear filtering leaves a third of the mean square, a mip nothing. In pairs along y: two
  // thirds, and +-1 in turn in the mip.
  std::vector<float> checker(512);
  for (size_t i = 0; i < 512; ++i) checker[i] = i % 2 ? 1.0f : -1.0f;
  std::vector<float> pairs(512);
  for (size_t i = 0; i < 512; ++i) pairs[i] = i / 8 % 4 < 2 ? 1.0f : -1.0f;
  const MippedVolume volume = make_mips({checker, pairs}, 8, 2);
  REQUIRE(volume.variances.size() == 8);
  CHECK(volume.variances[0] == 1.0f);
  CHECK(volume.variances[1] == 1.0f);
  CHECK(mean_square_between(checker, 8) == doctest::Approx(1.0 / 3.0));
  CHECK(mean_square_between(pairs, 8) == doctest::Approx(2.0 / 3.0));
  CHECK(volume.variances[2] == 0.0f);
  CHECK(volume.variances[3] == doctest::Approx(0.5));
  CHECK(volume.variances[5] == 0.0f);
  CHECK(volume.texels.size() == bytes_of_mips(8, 4));
  CHECK(bytes_of_mips(8, 4) == (512 + 64 + 8 + 1) * 4);
  uint16_t first = 0;
  std::memcpy(&first, volume.texels.data(), 2);
  CHECK(first == std::lround(65535.0 * (0.5 - 1.0 / 8.0)));
}

TEST_CASE("volume tools: a curl has variance 1 each way and no divergence") {
  constexpr size_t kSize = 16;
  std::array<std::vector<float>, 3> potential;
  uint32_t state = 1;
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < kSize * kSize * kSize; ++i)
      potential[c].push_back(static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) *
                             (c == 1 ? 1.5f : 1.0f));
  const auto curl = curl_of(potential, kSize);
  double divergence = 0.0;
  for (size_t z = 0; z < kSize; ++z)
    for (size_t y = 0; y < kSize; ++y)
      for (size_t x = 0; x < kSize; ++x) {
        const auto at = [&](size_t c, size_t i, size_t j, size_t k) {
          return static_cast<double>(curl[c][(k % kSize * kSize + j % kSize) * kSize + i % kSize]);
        };
        divergence = std::max(divergence,
                              std::abs(at(0, x + 1, y, z) - at(0, x + kSize - 1, y, z) + at(1, x, y + 1, z) -
                                       at(1, x, y + kSize - 1, z) + at(2, x, y, z + 1) - at(2, x, y, z + kSize - 1)));
      }
  CHECK(divergence < 1e-5);
  for (size_t c = 0; c < 3; ++c) {
    CHECK(mean_of(curl[c]) == doctest::Approx(0.0).epsilon(1e-4));
    CHECK(mean_of(curl[c], 2) == doctest::Approx(1.0).epsilon(1e-4));
  }
}

TEST_CASE("noise recipes: cells have the same number exactly where the volume repeats") {
  for (const int cycles : {4, 7, 9, 35, 64}) {
    CAPTURE(cycles);
    const shared::NoiseTerm term =
        noise_dispatches({{.cycles = cycles}}, 128, 5u + static_cast<uint32_t>(cycles))[0].term;
    const glm::mat3& lattice = term.cells_from_uvw;
    CHECK(static_cast<double>(term.cell_count) == doctest::Approx(std::pow(cycles, 3)).epsilon(0.15));
    CHECK(static_cast<double>(term.cell_count) == std::abs(std::round(glm::determinant(glm::dmat3(lattice)))));
    for (int axis = 0; axis < 3; ++axis) CHECK(shared::cell_number(lattice[axis], term.step, term.cell_count) == 0);
    // As many cells in the cube as numbers, so: each number once.
    std::vector<int> found(term.cell_count);
    const glm::dmat3 uvw_from_cells = glm::inverse(glm::dmat3(lattice));
    const int reach = 2 * cycles;
    for (int z = -reach; z <= reach; ++z)
      for (int y = -reach; y <= reach; ++y)
        for (int x = -reach; x <= reach; ++x) {
          const glm::dvec3 uvw = uvw_from_cells * glm::dvec3(x, y, z) + 1e-9;
          if (glm::any(glm::lessThan(uvw, glm::dvec3(0.0))) || glm::any(glm::greaterThanEqual(uvw, glm::dvec3(1.0))))
            continue;
          ++found[shared::cell_number(glm::vec3(x, y, z), term.step, term.cell_count)];
        }
    CHECK(std::all_of(found.begin(), found.end(), [](int n) { return n == 1; }));
    // Turned: no axis of the lattice is one of the volume.
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) CHECK(std::abs(lattice[c][r]) < 0.97f * static_cast<float>(cycles));
  }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: every channel has mean 0 and variance 1") {
  for (const Channel& c : channels_of(built_in(device))) {
    CAPTURE(c.name);
    const std::vector<float> values = channel_of(device, c.image, c.channel);
    REQUIRE(values.size() == c.size * c.size * c.size);
    CHECK(std::abs(mean_of(values)) < 0.01);
    CHECK(mean_of(values, 2) == doctest::Approx(1.0).epsilon(0.01));
  }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: all but turbulence are normal") {
  for (const Channel& c : channels_of(built_in(device))) {
    if (std::string(c.name).starts_with("turbulence")) continue;
    CAPTURE(c.name);
    const std::vector<float> values = channel_of(device, c.image, c.channel);
    const double step = 8.0 / 65535.0;  // of 16 bits
    for (const double z : {-2.0, -1.0, 0.0, 1.0, 2.0}) {
      CAPTURE(z);
      CHECK(share_above(values, static_cast<float>(z)) <= normal_share_above(z - step) + 1e-3);
      CHECK(share_above(values, static_cast<float>(z)) >= normal_share_above(z + step) - 1e-3);
    }
  }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: nothing shows where a volume repeats") {
  for (const Channel& c : channels_of(built_in(device))) {
    CAPTURE(c.name);
    const std::vector<float> values = channel_of(device, c.image, c.channel);
    for (size_t axis = 0; axis < 3; ++axis) {
      const Steps steps = steps_of(values, c.size, axis);
      CHECK(steps.edge < 1.3 * steps.inner);
      CHECK(steps.edge > 0.7 * steps.inner);
    }
  }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: the channels are independent of each other") {
  const CloudNoise& noise = built_in(device);
  std::vector<std::vector<float>> all;
  for (size_t c = 0; c < 4; ++c) all.push_back(channel_of(device, noise.field(), c));
  for (size_t c = 0; c < 2; ++c) all.push_back(channel_of(device, noise.cells(), c));
  for (size_t a = 0; a < all.size(); ++a)
    for (size_t b = 0; b < a; ++b) {
      CAPTURE(a);
      CAPTURE(b);
      CHECK(std::abs(correlation(all[a], all[b])) < 0.05);
    }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: turbulence has next to no divergence, and alpha 1") {
  const CloudNoise& noise = built_in(device);
  const size_t n = noise.turbulence_size();
  std::vector<std::vector<float>> v;
  for (size_t c = 0; c < 4; ++c) v.push_back(channel_of(device, noise.turbulence(), c));
  double divergence = 0.0, parts = 0.0;
  for (size_t i = 0; i < v[0].size(); ++i) {
    double sum = 0.0;
    for (size_t axis = 0, stride = 1; axis < 3; ++axis, stride *= n) {
      const size_t at = i / stride % n, row = i - at * stride;
      const double d = v[axis][row + (at + 1) % n * stride] - v[axis][row + (at + n - 1) % n * stride];
      sum += d;
      parts += d * d;
    }
    divergence += sum * sum;
  }
  MESSAGE("divergence: ", std::sqrt(divergence / parts), " of its parts");
  CHECK(std::sqrt(divergence / parts) < 0.05);
  CHECK(std::all_of(v[3].begin(), v[3].end(), [](float a) { return a == MippedVolume::kRange; }));
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: what is left of the variance follows the fit, mip by mip") {
  const CloudNoise& noise = built_in(device);
  const CloudNoise::Fades& f = noise.fades();
  const CloudNoise::Fade fades[5] = {f.field, f.cells_round, f.cells_fractal, f.shape, f.detail};
  for (size_t k = 0; k < 5; ++k) {
    const std::vector<float>& variances = noise.variances()[k];
    REQUIRE(variances.size() == (k == 4 ? 6 : 8));
    CHECK(variances[0] == doctest::Approx(1.0).epsilon(0.001));
    for (size_t mip = 0; mip < variances.size(); ++mip) {
      CAPTURE(k);
      CAPTURE(mip);
      if (mip > 0) CHECK(variances[mip] < variances[mip - 1]);
      const float left = shared::variance_left(static_cast<float>(mip), fades[k].start, fades[k].per_lod);
      CHECK(std::abs(left - variances[mip]) < 0.08f);
    }
  }
}

TEST_CASE_FIXTURE(GpuFixture, "cloud noise: what is made anew has the bytes of what was cached") {
  const CloudNoise& noise = built_in(device);
  const std::filesystem::path cache = cache_dir();
  if (cache.empty()) return;
  // A cache that lacks the small ones and holds one torn file; 128^3 takes its time.
  const test::TempFolder folder;
  for (const char* name : {"clouds.field.bin", "clouds.cells.bin", "clouds.shape.bin", "clouds.detail.bin"})
    std::filesystem::copy_file(cache / name, folder / name);
  std::filesystem::resize_file(folder / "clouds.detail.bin", 1000);
  const char* before = std::getenv("NEPHO_CACHE");
  const std::string kept = before ? before : "";
  setenv("NEPHO_CACHE", folder.path().c_str(), 1);
  const CloudNoise again(device);
  const CloudNoise cached(device);
  before ? setenv("NEPHO_CACHE", kept.c_str(), 1) : unsetenv("NEPHO_CACHE");
  for (const CloudNoise* other : {&again, &cached}) {
    CHECK(device.download(other->detail(), 1) == device.download(noise.detail(), 1));
    CHECK(device.download(other->turbulence()) == device.download(noise.turbulence()));
    CHECK(device.download(other->blue()) == device.download(noise.blue()));
    CHECK(device.download(other->shape(), 3) == device.download(noise.shape(), 3));
    CHECK(other->variances()[4] == noise.variances()[4]);
  }
  for (const char* name : {"clouds.detail.bin", "clouds.turbulence.bin", "clouds.blue.bin"})
    CHECK(test::bytes_of(folder / name) == test::bytes_of(cache / name));
}
