#include "compare/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

#include "base/error.h"

namespace nepho {

namespace {

constexpr double kPiD = 3.14159265358979323846;

// Constants of the paper, sections 4.1.2, 4.1.3 and 4.2, under their names there.
constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95, kQf = 0.5, kW = 0.082;

/// Contrast sensitivity of one opponent channel as a sum of two Gaussians over the visual angle z, degrees:
/// a1 sqrt(pi/b1) exp(-pi^2 z^2 / b1) + a2 sqrt(pi/b2) exp(-pi^2 z^2 / b2).
struct Sensitivity {
  double a1, b1, a2, b2;
};
constexpr std::array<Sensitivity, 3> kSensitivity = {Sensitivity{1.0, 0.0047, 0.0, 1.0e-5},  // achromatic, Yy
                                                     Sensitivity{1.0, 0.0053, 0.0, 1.0e-5},  // red-green, Cx
                                                     Sensitivity{34.1, 0.04, 13.5, 0.025}};  // blue-yellow, Cz
constexpr double kWidest = 0.04;  // the largest b: its Gaussian sets the size of all three filters

// sRGB to XYZ (D65) as rational numbers; columns, as GLM has them.
const glm::dmat3 kXyzFromRgb(10135552.0 / 24577794.0, 2613072.0 / 12288897.0, 1425312.0 / 73733382.0,
                             8788810.0 / 24577794.0, 8788810.0 / 12288897.0, 8788810.0 / 73733382.0,
                             4435075.0 / 24577794.0, 887015.0 / 12288897.0, 70074185.0 / 73733382.0);
const glm::dmat3 kRgbFromXyz = glm::inverse(kXyzFromRgb);
const glm::dvec3 kWhite = kXyzFromRgb * glm::dvec3(1.0);

double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

glm::dvec3 ycxcz_from_rgb(const glm::dvec3& rgb) {
  const glm::dvec3 n = kXyzFromRgb * rgb / kWhite;
  return {116.0 * n.y - 16.0, 500.0 * (n.x - n.y), 200.0 * (n.y - n.z)};
}

glm::dvec3 rgb_from_ycxcz(const glm::dvec3& v) {
  const double y = (v.x + 16.0) / 116.0;
  return kRgbFromXyz * (glm::dvec3(y + v.y / 500.0, y, y - v.z / 200.0) * kWhite);
}

/// CIE L*a*b*, its a* and b* scaled by L*/100 for the Hunt effect: dark colours look less colourful.
glm::dvec3 hunt_lab_from_rgb(const glm::dvec3& rgb) {
  const auto f = [](double t) {
    constexpr double d = 6.0 / 29.0;
    return t > d * d * d ? std::cbrt(t) : t / (3.0 * d * d) + 4.0 / 29.0;
  };
  const glm::dvec3 n = kXyzFromRgb * rgb / kWhite;
  const double l = 116.0 * f(n.y) - 16.0;
  return {l, 0.01 * l * 500.0 * (f(n.x) - f(n.y)), 0.01 * l * 200.0 * (f(n.y) - f(n.z))};
}

/// Abasi et al. 2020: city block in lightness, Euclidean in colour.
double hyab(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 d = a - b;
  return std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z);
}

/// Largest colour difference that counts: green to blue, to the power q_c.
double largest_difference() {
  return std::pow(hyab(hunt_lab_from_rgb({0.0, 1.0, 0.0}), hunt_lab_from_rgb({0.0, 0.0, 1.0})), kQc);
}

/// Differences up to p_c of the largest fill 0..p_t, the rest p_t..1.
double redistributed(double difference, double largest) {
  const double knee = kPc * largest;
  return difference < knee ? kPt / knee * difference : kPt + (difference - knee) / (largest - knee) * (1.0 - kPt);
}

void scale(std::vector<double>& weights, double factor) {
  for (double& w : weights) w *= factor;
}

double sum(const std::vector<double>& weights) {
  double total = 0.0;
  for (const double w : weights) total += w;
  return total;
}

/// A channel as the eye resolves it.
Plane blurred(const Plane& channel, const Sensitivity& s, double ppd) {
  const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(kWidest / (2.0 * kPiD * kPiD)) * ppd));
  // exp(-pi^2 z^2 / b) has the standard deviation sqrt(b / 2) / pi, degrees.
  const auto part = [&](double b) { return gaussian_weights(std::sqrt(0.5 * b) / kPiD * ppd, radius); };
  std::vector<double> first = part(s.b1), second = part(s.b2);
  const double weight1 = s.a1 * std::sqrt(kPiD / s.b1), weight2 = s.a2 * std::sqrt(kPiD / s.b2);
  const double total = weight1 * sum(first) * sum(first) + weight2 * sum(second) * sum(second);
  std::vector<double> scaled = first;
  scale(scaled, weight1 / total);
  Plane out = filtered(channel, first, scaled);
  if (s.a2 == 0.0) return out;
  scaled = second;
  scale(scaled, weight2 / total);
  const Plane more = filtered(channel, second, scaled);
  for (size_t i = 0; i < out.values.size(); ++i) out.values[i] += more.values[i];
  return out;
}

/// Makes the positive weights sum to 1 and the negative ones to -1.
void normalise_signs(std::vector<double>& weights) {
  double positive = 0.0, negative = 0.0;
  for (const double w : weights) (w > 0.0 ? positive : negative) += std::abs(w);
  for (double& w : weights) w /= w > 0.0 ? positive : negative;
}

/// Length of the vector of a feature's strength along x and along y.
Plane feature_strength(const Plane& luminance, const std::vector<double>& across, const std::vector<double>& along) {
  Plane out = filtered(luminance, across, along);
  const Plane other = filtered(luminance, along, across);
  for (size_t i = 0; i < out.values.size(); ++i) out.values[i] = std::hypot(out.values[i], other.values[i]);
  return out;
}

/// One of the two pictures, prepared.
struct Seen {
  std::array<Plane, 3> lab;  ///< blurred, Hunt-adjusted
  Plane edges, points;
};

Seen see(uint32_t width, uint32_t height, std::span<const glm::vec3> srgb, double ppd) {
  std::array<Plane, 3> opponent = {Plane(width, height), Plane(width, height), Plane(width, height)};
  Plane luminance(width, height);
  for (size_t i = 0; i < srgb.size(); ++i) {
    const glm::dvec3 v = glm::clamp(glm::dvec3(srgb[i]), 0.0, 1.0);
    const glm::dvec3 o = ycxcz_from_rgb({linear_from_srgb(v.x), linear_from_srgb(v.y), linear_from_srgb(v.z)});
    for (size_t c = 0; c < 3; ++c) opponent[c].values[i] = static_cast<float>(o[static_cast<int>(c)]);
    luminance.values[i] = static_cast<float>((o.x + 16.0) / 116.0);
  }
  for (size_t c = 0; c < 3; ++c) opponent[c] = blurred(opponent[c], kSensitivity[c], ppd);
  for (size_t i = 0; i < srgb.size(); ++i) {
    const glm::dvec3 o(opponent[0].values[i], opponent[1].values[i], opponent[2].values[i]);
    const glm::dvec3 lab = hunt_lab_from_rgb(glm::clamp(rgb_from_ycxcz(o), 0.0, 1.0));
    for (size_t c = 0; c < 3; ++c) opponent[c].values[i] = static_cast<float>(lab[static_cast<int>(c)]);
  }

  // First and second derivatives of a Gaussian as wide as a feature of w degrees.
  const double sigma = 0.5 * kW * ppd;
  const int radius = static_cast<int>(std::ceil(3.0 * sigma));
  std::vector<double> along = gaussian_weights(sigma, radius), edge = along, point = along;
  for (int x = -radius; x <= radius; ++x) {
    const size_t k = static_cast<size_t>(x + radius);
    edge[k] *= -x;
    point[k] *= x * x / (sigma * sigma) - 1.0;
  }
  normalise_signs(edge);
  normalise_signs(point);
  scale(along, 1.0 / sum(along));
  return {std::move(opponent), feature_strength(luminance, edge, along), feature_strength(luminance, point, along)};
}

}  // namespace

double FlipView::pixels_per_degree() const { return distance_m * width_px / width_m * kPiD / 180.0; }

Plane flip_map(uint32_t width, uint32_t height, std::span<const glm::vec3> test, std::span<const glm::vec3> reference,
               const FlipView& view) {
  NEPHO_ASSERT(test.size() == size_t{width} * height && reference.size() == test.size());
  const double ppd = view.pixels_per_degree();
  const Seen a = see(width, height, test, ppd), b = see(width, height, reference, ppd);
  const double largest = largest_difference();
  Plane out(width, height);
  for (size_t i = 0; i < out.values.size(); ++i) {
    const auto lab = [i](const Seen& s) {
      return glm::dvec3(s.lab[0].values[i], s.lab[1].values[i], s.lab[2].values[i]);
    };
    const double colour = redistributed(std::pow(hyab(lab(a), lab(b)), kQc), largest);
    const double feature =
        std::max(std::abs(static_cast<double>(a.edges.values[i]) - static_cast<double>(b.edges.values[i])),
                 std::abs(static_cast<double>(a.points.values[i]) - static_cast<double>(b.points.values[i])));
    const double feature_error = std::min(std::pow(feature / std::sqrt(2.0), kQf), 1.0);
    out.values[i] = static_cast<float>(std::pow(colour, 1.0 - feature_error));
  }
  return out;
}

}  // namespace nepho
