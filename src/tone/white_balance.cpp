#include "tone/white_balance.h"

#include <glm/matrix.hpp>

namespace nepho {

namespace {

/// XYZ, Y = 1, of CIE daylight (CIE 15:2004, eq. 3.2 to 3.4). The locus is for 4000..25000 K.
glm::dvec3 daylight_xyz(double k) {
  const double x = k <= 7000.0 ? -4.6070e9 / (k * k * k) + 2.9678e6 / (k * k) + 0.09911e3 / k + 0.244063
                               : -2.0064e9 / (k * k * k) + 1.9018e6 / (k * k) + 0.24748e3 / k + 0.237040;
  const double y = -3.0 * x * x + 2.870 * x - 0.275;
  return {x / y, 1.0, (1.0 - x - y) / y};
}

// Columns, as GLM has them. IEC 61966-2-1 and Lindbloom's Bradford matrix.
const glm::dmat3 kXyzFromRec709(0.4123908, 0.2126390, 0.0193308, 0.3575843, 0.7151687, 0.1191948, 0.1804808, 0.0721923,
                                0.9505322);
const glm::dmat3 kConesFromXyz(0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296);

}  // namespace

glm::dmat3 rec709_white_balance(double daylight_k) {
  const glm::dvec3 from = kConesFromXyz * daylight_xyz(daylight_k);
  const glm::dvec3 to = kConesFromXyz * daylight_xyz(6504.0);
  const glm::dmat3 scale(to.x / from.x, 0, 0, 0, to.y / from.y, 0, 0, 0, to.z / from.z);
  const glm::dmat3 cones_from_709 = kConesFromXyz * kXyzFromRec709;
  return glm::inverse(cones_from_709) * scale * cones_from_709;
}

}  // namespace nepho
