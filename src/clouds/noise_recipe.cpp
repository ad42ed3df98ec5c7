#include "clouds/noise_recipe.h"

#include <array>
#include <cmath>
#include <glm/gtc/quaternion.hpp>
#include <numeric>

namespace nepho {
namespace {

/// Repeatable numbers, the same with every compiler (PCG, Jarzynski and Olano 2020).
class Random {
 public:
  explicit Random(uint32_t seed) : state_(seed * 747796405u + 2891336453u) {}
  uint32_t bits() {
    state_ = state_ * 747796405u + 2891336453u;
    const uint32_t word = ((state_ >> ((state_ >> 28u) + 4u)) ^ state_) * 277803737u;
    return (word >> 22u) ^ word;
  }
  double uniform() { return bits() * 0x1p-32; }  ///< 0..1

 private:
  uint32_t state_;
};

using Whole = std::array<int64_t, 3>;

struct Lattice {
  glm::dmat3 cells_from_uvw{0.0};
  int64_t cell_count = 0;
  Whole step{};
};

/// Numbers the cells of a lattice whose periods are the columns of `periods`: a row of the adjugate gives a multiple of
/// the determinant, so 0, for whole periods; where it has no factor in common with the determinant it gives 0 for
/// nothing else, and every number. There are lattices without such a row.
bool number_cells(Lattice& lattice) {
  const glm::dmat3& m = lattice.cells_from_uvw;
  const auto count = static_cast<int64_t>(std::llround(std::abs(glm::determinant(m))));
  if (count == 0) return false;
  const auto entry = [&](int row, int column) { return static_cast<int64_t>(m[column % 3][row % 3]); };
  for (int r = 0; r < 3; ++r) {
    Whole step{};
    int64_t common = count;
    for (int c = 0; c < 3; ++c) {
      const int64_t cofactor = entry(c + 1, r + 1) * entry(c + 2, r + 2) - entry(c + 1, r + 2) * entry(c + 2, r + 1);
      step[static_cast<size_t>(c)] = (cofactor % count + count) % count;
      common = std::gcd(common, step[static_cast<size_t>(c)]);
    }
    if (common != 1) continue;
    lattice.cell_count = count;
    lattice.step = step;
    return true;
  }
  return false;
}

/// A turned lattice of about `cycles` cells a side whose axes are whole numbers: the nearest to a rotation of some
/// tries, and none along the volume's own axes, where rows would show.
Lattice turned_lattice(int cycles, Random& random) {
  Lattice best;
  double least = 1e9;
  for (int tries = 0; tries < 24 || best.cell_count == 0; ++tries) {
    glm::dquat turn;
    for (int i = 0; i < 4; ++i) turn[i] = random.uniform() - 0.5;
    if (glm::length(turn) < 0.05 || glm::length(turn) > 0.5) continue;  // in a ball: every turn as likely
    const glm::dmat3 exact = glm::mat3_cast(glm::normalize(turn)) * static_cast<double>(cycles);
    double error = 0.0, largest = 0.0;
    Lattice lattice;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) {
        lattice.cells_from_uvw[c][r] = std::round(exact[c][r]);
        error = std::max(error, std::abs(lattice.cells_from_uvw[c][r] - exact[c][r]));
        largest = std::max(largest, std::abs(lattice.cells_from_uvw[c][r]));
      }
    if (largest > 0.94 * cycles || error >= least || !number_cells(lattice)) continue;
    least = error;
    best = lattice;
  }
  return best;
}

}  // namespace

std::vector<NoiseDispatch> noise_dispatches(const NoiseRecipe& recipe, uint32_t size, uint32_t seed) {
  std::vector<NoiseDispatch> dispatches;
  Random random(seed);
  for (const NoiseOctaves& octaves : recipe) {
    float weight = octaves.amplitude;
    for (int i = 0, cycles = octaves.cycles; i < octaves.count; ++i, cycles *= 2, weight *= octaves.gain) {
      const Lattice lattice = turned_lattice(cycles, random);
      const auto uniform = [&] { return static_cast<float>(random.uniform()); };
      const float x = uniform(), y = uniform(), z = uniform();
      dispatches.push_back({.dome = octaves.domes,
                            .term = {.cells_from_uvw = glm::mat3(lattice.cells_from_uvw),
                                     .step = glm::uvec3(lattice.step[0], lattice.step[1], lattice.step[2]),
                                     .cell_count = static_cast<uint32_t>(lattice.cell_count),
                                     .shift = glm::vec3(x, y, z),
                                     .weight = weight,
                                     .bend = octaves.bend,
                                     .seed = random.bits(),
                                     .size = size}});
    }
  }
  return dispatches;
}

}  // namespace nepho
