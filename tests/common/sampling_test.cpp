#include "common/sampling.h"

#include <doctest/doctest.h>

#include <algorithm>

#include "common/random.h"
#include "statistics.h"

using namespace nepho;
using namespace nepho::test;
using glm::dvec3;
using glm::vec2;
using glm::vec3;
using shared::Random;
using shared::random_stream;
using shared::random_unit;

namespace {

constexpr int kDraws = 1 << 18;
constexpr size_t kBins = 200;
constexpr double kPi = 3.14159265358979323846;

/// Henyey and Greenstein's share of cosines below `c`, in double.
double hg_below(double c, double g) {
  if (std::abs(g) < 1e-9) return 0.5 * (1.0 + c);
  const auto root = [&](double x) { return 1.0 / std::sqrt(1.0 + g * g - 2.0 * g * x); };
  return (1.0 - g * g) / (2.0 * g) * (root(c) - root(-1.0));
}

template <typename F, typename B>
void check_cosines(F&& draw, B&& below, double mean) {
  Random r = random_stream(1u, 2u, 3u);
  Moments m;
  std::vector<double> counts(kBins, 0.0), expected(kBins, 0.0);
  for (int i = 0; i < kDraws; ++i) {
    const float c = draw(random_unit(r));
    REQUIRE(c >= -1.0f);
    REQUIRE(c <= 1.0f);
    m.add(static_cast<double>(c));
    counts[std::min(static_cast<size_t>((c + 1.0f) * 0.5f * static_cast<float>(kBins)), kBins - 1)] += 1.0;
  }
  for (size_t b = 0; b < kBins; ++b) {
    const double low = -1.0 + 2.0 * static_cast<double>(b) / kBins, high = low + 2.0 / kBins;
    expected[b] = kDraws * (below(high) - below(low));
  }
  CHECK(std::abs(m.mean() - mean) < 4.0 * m.error());
  CHECK(std::abs(chi_square_sigmas(counts, expected)) < 4.0);
}

const std::vector<vec3>& axes() {
  static const std::vector<vec3> all = [] {
    std::vector<vec3> v = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
    for (const float e : {1e-7f, 1e-5f, 1e-3f})
      for (const float z : {-1.0f, 1.0f, -1e-8f, 1e-8f})
        for (const vec2 s : {vec2(e, 0), vec2(0, -e), vec2(e, e), vec2(-e, e), vec2(1, e)})
          v.push_back(glm::normalize(vec3(s.x, s.y, z)));
    Random r = random_stream(9u, 9u, 9u);
    for (int i = 0; i < 2000; ++i) {
      const double z = 2.0 * static_cast<double>(random_unit(r)) - 1.0,
                   p = 2.0 * kPi * static_cast<double>(random_unit(r));
      const double s = std::sqrt(1.0 - z * z);
      v.push_back(vec3(dvec3(s * std::cos(p), s * std::sin(p), z)));
    }
    return v;
  }();
  return all;
}

}  // namespace

TEST_CASE("cosines drawn from Henyey-Greenstein have the mean g and its density") {
  for (const double g : {-0.9, -0.5, -0.01, -1e-4, 0.0, 1e-4, 9e-4, 1.1e-3, 0.01, 0.3, 0.7, 0.85, 0.9}) {
    CAPTURE(g);
    const auto gf = static_cast<float>(g);
    check_cosines([&](float u) { return shared::sample_hg_cosine(gf, u); }, [&](double c) { return hg_below(c, g); },
                  g);
  }
}

TEST_CASE("the inversion of Henyey-Greenstein is exact") {
  for (const double g : {-0.9, -0.3, -1e-3, -5e-4, 0.0, 1e-4, 9.9e-4, 1.01e-3, 0.02, 0.5, 0.9, 0.98})
    for (int i = 1; i < 100; ++i) {
      const double u = i / 100.0;
      const double c = static_cast<double>(shared::sample_hg_cosine(static_cast<float>(g), static_cast<float>(u)));
      CAPTURE(g);
      CAPTURE(u);
      // u counts from the forward direction. A float's cosine near 1 is known to 2e-7.
      const double density = (1.0 - g * g) / 2.0 / std::pow(1.0 + g * g - 2.0 * g * c, 1.5);
      CHECK(std::abs(hg_below(c, g) - (1.0 - u)) < 1e-5 + 2e-7 * density);
    }
}

TEST_CASE("phase_hg is the density of the drawn cosines") {
  // The closed form of the share against the shader's density, over a few bins.
  for (const float g : {-0.7f, 0.0f, 0.4f, 0.85f})
    for (double low = -1.0; low < 0.99; low += 0.1) {
      double sum = 0.0;
      for (int i = 0; i < 1000; ++i)
        sum += static_cast<double>(shared::phase_hg(static_cast<float>(low + (i + 0.5) * 1e-4), g)) * 1e-4 * 2.0 * kPi;
      const double gd = static_cast<double>(g);
      CHECK(sum == doctest::Approx(hg_below(low + 0.1, gd) - hg_below(low, gd)).epsilon(1e-3));
    }
}

TEST_CASE("cosines drawn from two lobes have their weighted mean and density") {
  struct Lobes {
    double g0, g1, w;
  };
  for (const Lobes l :
       {Lobes{0.85, -0.3, 0.3}, {0.8, -0.2, 0.0}, {0.8, -0.2, 1.0}, {0.0, 0.9, 0.01}, {0.6, 0.6, 0.5}}) {
    CAPTURE(l.g0);
    CAPTURE(l.g1);
    CAPTURE(l.w);
    check_cosines(
        [&](float u) {
          return shared::sample_lobes_cosine(
              {static_cast<float>(l.g0), 0.0f, static_cast<float>(l.g1), 0.0f, static_cast<float>(l.w)}, u);
        },
        [&](double c) { return (1.0 - l.w) * hg_below(c, l.g0) + l.w * hg_below(c, l.g1); },
        (1.0 - l.w) * l.g0 + l.w * l.g1);
  }
}

namespace {

/// Draine's share of cosines above `c`, by quadrature in double that crowds around forward.
double draine_above(double c, double g, double alpha) {
  const double end = std::acos(c);
  double sum = 0.0;
  constexpr int kNodes = 4000;
  for (int i = 0; i < kNodes; ++i) {
    const double u = (i + 0.5) / kNodes, theta = end * u * u * u, x = std::cos(theta);
    const double near = (1.0 - g) * (1.0 - g) + 4.0 * g * std::pow(std::sin(0.5 * theta), 2.0);
    sum += (1.0 - g * g) * (1.0 + alpha * x * x) / (2.0 * near * std::sqrt(near)) * std::sin(theta) * 3.0 * end * u *
           u / kNodes;
  }
  return sum / (1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0);
}

struct Draine {
  double g, alpha;
};
constexpr Draine kDraines[] = {{0.85, 1.0},  {0.0, 1.0},   {-0.6, 1.0},  {1e-3, 1.0}, {0.95, 1.0},
                               {0.51, 17.1}, {0.56, 22.0}, {0.63, 32.3}, {0.3, 100.0}};

}  // namespace

TEST_CASE("the inversion of Draine's lobe is exact") {
  for (const Draine& lobe : kDraines) {
    CAPTURE(lobe.g);
    CAPTURE(lobe.alpha);
    const auto g = static_cast<float>(lobe.g), alpha = static_cast<float>(lobe.alpha);
    float before = 2.0f;
    for (int i = 0; i <= 200; ++i) {
      const double u = std::min(i / 200.0, 0.99999994);
      CAPTURE(u);
      const float c = shared::sample_draine_cosine(g, alpha, static_cast<float>(u));
      CHECK(c <= before);
      before = c;
      const double density = 2.0 * kPi * static_cast<double>(shared::phase_draine(c, g, alpha));
      CHECK(std::abs(draine_above(static_cast<double>(c), lobe.g, lobe.alpha) - u) < 1e-5 + 2e-7 * density);
    }
  }
}

TEST_CASE("cosines drawn from Draine's lobes have its mean and density") {
  for (const Draine& lobe : kDraines) {
    CAPTURE(lobe.g);
    CAPTURE(lobe.alpha);
    const double g = lobe.g, a = lobe.alpha;
    const double mean = g * (1.0 + a * (3.0 + 2.0 * g * g) / 5.0) / (1.0 + a * (1.0 + 2.0 * g * g) / 3.0);
    check_cosines(
        [&](float u) { return shared::sample_draine_cosine(static_cast<float>(g), static_cast<float>(a), u); },
        [&](double c) { return 1.0 - draine_above(c, g, a); }, mean);
  }
}

TEST_CASE("draws without alpha are those of Henyey and Greenstein, whichever the lobe") {
  for (float u = 0.0f; u < 1.0f; u += 0.013f) {
    CHECK(shared::sample_draine_cosine(0.85f, 0.0f, u) == shared::sample_hg_cosine(0.85f, u));
    CHECK(shared::sample_lobes_cosine({0.2f, 5.0f, 0.85f, 0.0f, 1.0f}, u) == shared::sample_hg_cosine(0.85f, u));
    CHECK(shared::sample_lobes_cosine({0.3f, 2.0f, 0.85f, 0.0f, 0.0f}, u) ==
          shared::sample_draine_cosine(0.3f, 2.0f, u));
  }
}

TEST_CASE("a tangent is a unit vector across its axis, for axes everywhere") {
  for (const vec3& n : axes()) {
    const dvec3 t = dvec3(shared::tangent_of(n));
    REQUIRE(std::abs(glm::length(t) - 1.0) < 1e-6);
    REQUIRE(std::abs(glm::dot(t, dvec3(n))) < 1e-6);
  }
}

TEST_CASE("a direction about an axis keeps its cosine and its length, for axes everywhere") {
  for (const vec3& n : axes())
    for (const float c : {-1.0f, -0.999f, -0.5f, 0.0f, 1e-3f, 0.7f, 0.999999f, 1.0f})
      for (const float u : {0.0f, 0.1f, 0.25f, 0.6f, 0.99999994f}) {
        const dvec3 d = dvec3(shared::direction_about(n, c, u));
        REQUIRE(std::abs(glm::length(d) - 1.0) < 3e-7);
        REQUIRE(std::abs(glm::dot(d, dvec3(n)) - static_cast<double>(c)) < 6e-7);
      }
}

TEST_CASE("directions about an axis turn about it by 2 pi u") {
  for (const vec3& n : axes()) {
    const dvec3 axis = dvec3(n);
    const auto across = [&](float u) {
      const dvec3 d = dvec3(shared::direction_about(n, 0.3f, u));
      return glm::normalize(d - axis * glm::dot(d, axis));
    };
    const dvec3 first = across(0.0f);
    for (const float u : {0.125f, 0.5f, 0.75f}) {
      const double angle = std::atan2(glm::dot(glm::cross(first, across(u)), axis), glm::dot(first, across(u)));
      REQUIRE(std::abs(std::remainder(angle - 2.0 * kPi * static_cast<double>(u), 2.0 * kPi)) < 1e-5);
    }
  }
}

TEST_CASE("directions over a hemisphere have the density cos / pi") {
  for (const vec3& n : {vec3(0, 0, -1), glm::normalize(vec3(1, -2, 0.5f))}) {
    Random r = random_stream(5u, 6u, 7u);
    const dvec3 axis = dvec3(n), t = dvec3(shared::tangent_of(n)), b = glm::cross(axis, t);
    Moments m;
    constexpr size_t kCos = 20, kTurn = 16;
    std::vector<double> counts(kCos * kTurn, 0.0), expected;
    for (int i = 0; i < kDraws; ++i) {
      const float u = random_unit(r);
      const dvec3 d = dvec3(shared::sample_cosine_hemisphere(n, vec2(u, random_unit(r))));
      const double c = glm::dot(d, axis);
      REQUIRE(c > -1e-6);
      m.add(c);
      const double turn = std::atan2(glm::dot(d, b), glm::dot(d, t)) / (2.0 * kPi) + 0.5;
      counts[std::min(static_cast<size_t>(std::max(c, 0.0) * kCos), kCos - 1) * kTurn +
             std::min(static_cast<size_t>(turn * kTurn), kTurn - 1)] += 1.0;
    }
    for (size_t i = 0; i < kCos * kTurn; ++i) {
      const double low = static_cast<double>(i / kTurn) / kCos, high = low + 1.0 / kCos;
      expected.push_back(kDraws * (high * high - low * low) / kTurn);  // the share below a cosine is its square
    }
    CHECK(std::abs(m.mean() - 2.0 / 3.0) < 4.0 * m.error());
    CHECK(std::abs(chi_square_sigmas(counts, expected)) < 4.0);
  }
}

TEST_CASE("directions over a cap fill it evenly, down to the sun's disc") {
  for (const double radius_rad : {0.00465, 0.1, 1.5}) {
    CAPTURE(radius_rad);
    const double s = std::sin(0.5 * radius_rad), open = 2.0 * s * s;
    const vec3 axis = glm::normalize(vec3(0.3f, -0.4f, -0.8f));
    const dvec3 n = glm::normalize(dvec3(axis));
    Random r = random_stream(8u, 6u, 7u);
    Moments m;
    std::vector<double> counts(20, 0.0);
    for (int i = 0; i < kDraws; ++i) {
      const float u = random_unit(r);
      const dvec3 d =
          glm::normalize(dvec3(shared::sample_cap(axis, static_cast<float>(open), vec2(u, random_unit(r)))));
      const double half = 0.5 * glm::length(d - n);   // sin of half the angle
      const double share = 2.0 * half * half / open;  // even, 0..1
      REQUIRE(share < 1.02);
      m.add(share);
      counts[std::min(static_cast<size_t>(share * 20.0), size_t{19})] += 1.0;
    }
    CHECK(std::abs(m.mean() - 0.5) < 4.0 * m.error());
    CHECK(std::abs(chi_square_sigmas(counts, std::vector<double>(20, kDraws / 20.0))) < 4.0);
  }
}

TEST_CASE("slopes of facets are normal, with the variance asked for along every axis") {
  for (const double sigma2 : {1e-4, 0.02, 0.1}) {
    CAPTURE(sigma2);
    const vec3 up = glm::normalize(vec3(0.2f, 0.5f, -0.7f));
    const dvec3 n = dvec3(up), t = dvec3(shared::tangent_of(up)), b = glm::cross(n, t);
    Random r = random_stream(8u, 9u, 7u);
    Moments x, y, product, radius2;
    for (int i = 0; i < kDraws; ++i) {
      const float u = random_unit(r);
      const dvec3 d = dvec3(shared::sample_facet(up, static_cast<float>(sigma2), vec2(u, random_unit(r))));
      REQUIRE(std::abs(glm::length(d) - 1.0) < 3e-7);
      const double sx = -glm::dot(d, t) / glm::dot(d, n), sy = -glm::dot(d, b) / glm::dot(d, n);
      x.add(sx);
      y.add(sy);
      product.add(sx * sy);
      radius2.add((sx * sx + sy * sy) / sigma2);
    }
    const double variance_error = sigma2 * std::sqrt(2.0 / kDraws);
    CHECK(std::abs(x.mean()) < 4.0 * x.error());
    CHECK(std::abs(y.mean()) < 4.0 * y.error());
    CHECK(std::abs(product.mean()) < 4.0 * product.error());
    CHECK(std::abs(x.variance() - sigma2) < 4.0 * variance_error);
    CHECK(std::abs(y.variance() - sigma2) < 4.0 * variance_error);
    // The squared radius is exponential with the mean 2 and the variance 4.
    CHECK(std::abs(radius2.mean() - 2.0) < 4.0 * radius2.error());
    CHECK(radius2.variance() == doctest::Approx(4.0).epsilon(0.03));
  }
}
