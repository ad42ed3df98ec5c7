#include "clouds/statistics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numeric>
#include <stdexcept>

namespace nepho::test {
namespace {

using Complex = std::complex<double>;

/// In place, forward, unscaled; a power of two.
void fft(Complex* data, size_t n, const std::vector<Complex>& roots) {
  for (size_t i = 1, j = 0; i < n; ++i) {
    size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(data[i], data[j]);
  }
  for (size_t length = 2; length <= n; length <<= 1)
    for (size_t start = 0; start < n; start += length)
      for (size_t k = 0; k < length / 2; ++k) {
        const Complex even = data[start + k], odd = data[start + k + length / 2] * roots[k * (n / length)];
        data[start + k] = even + odd;
        data[start + k + length / 2] = even - odd;
      }
}

std::vector<Complex> roots_of(size_t n) {
  if (n == 0 || (n & (n - 1)) != 0) throw std::logic_error("a power of two is needed");
  std::vector<Complex> roots(n / 2 + 1);
  for (size_t k = 0; k < roots.size(); ++k)
    roots[k] = std::polar(1.0, -2.0 * M_PI * static_cast<double>(k) / static_cast<double>(n));
  return roots;
}

void fft_2d(std::vector<Complex>& data, size_t n) {
  const std::vector<Complex> roots = roots_of(n);
  std::vector<Complex> column(n);
  for (size_t y = 0; y < n; ++y) fft(&data[y * n], n, roots);
  for (size_t x = 0; x < n; ++x) {
    for (size_t y = 0; y < n; ++y) column[y] = data[y * n + x];
    fft(column.data(), n, roots);
    for (size_t y = 0; y < n; ++y) data[y * n + x] = column[y];
  }
}

size_t power_of_two_above(size_t n) {
  size_t p = 1;
  while (p < n) p <<= 1;
  return p;
}

/// Solves the normal equations by Gauss with pivots.
std::vector<double> solve(std::vector<double> a, std::vector<double> b) {
  const size_t n = b.size();
  for (size_t i = 0; i < n; ++i) {
    size_t pivot = i;
    for (size_t r = i + 1; r < n; ++r)
      if (std::abs(a[r * n + i]) > std::abs(a[pivot * n + i])) pivot = r;
    for (size_t c = 0; c < n; ++c) std::swap(a[i * n + c], a[pivot * n + c]);
    std::swap(b[i], b[pivot]);
    for (size_t r = i + 1; r < n; ++r) {
      const double f = a[r * n + i] / a[i * n + i];
      for (size_t c = i; c < n; ++c) a[r * n + c] -= f * a[i * n + c];
      b[r] -= f * b[i];
    }
  }
  for (size_t i = n; i-- > 0;) {
    for (size_t c = i + 1; c < n; ++c) b[i] -= a[i * n + c] * b[c];
    b[i] /= a[i * n + i];
  }
  return b;
}

long signed_frequency(size_t k, size_t n) {
  return k > n / 2 ? static_cast<long>(k) - static_cast<long>(n) : static_cast<long>(k);
}

constexpr double kLeastCycles = 2.0;
constexpr size_t kTerms = 16;

std::array<double, kTerms> smooth_terms(double kx, double ky) {
  // Along each axis, by octaves; 1.5 cycles are the window's own width.
  const double x = 0.5 * std::log(kx * kx + 2.25), y = 0.5 * std::log(ky * ky + 2.25);
  const double quadrant = kx * ky / (kx * kx + ky * ky + 1.0);
  return {1.0,           x,         y,         x * x,         x * y,         y * y,         x * x * x,
          x * x * y,     x * y * y, y * y * y, x * x * x * x, x * x * x * y, x * x * y * y, x * y * y * y,
          y * y * y * y, quadrant};
}

Grid without_plane(const Grid& image) {
  double sum = 0.0, sx = 0.0, sy = 0.0, xx = 0.0, yy = 0.0;
  const double mx = 0.5 * static_cast<double>(image.width - 1), my = 0.5 * static_cast<double>(image.height - 1);
  for (size_t y = 0; y < image.height; ++y)
    for (size_t x = 0; x < image.width; ++x) {
      const double dx = static_cast<double>(x) - mx, dy = static_cast<double>(y) - my, v = image.at(x, y);
      sum += v;
      sx += v * dx;
      sy += v * dy;
      xx += dx * dx;
      yy += dy * dy;
    }
  Grid flat = image;
  for (size_t y = 0; y < image.height; ++y)
    for (size_t x = 0; x < image.width; ++x)
      flat.at(x, y) -= sum / static_cast<double>(image.values.size()) + sx / xx * (static_cast<double>(x) - mx) +
                       sy / yy * (static_cast<double>(y) - my);
  return flat;
}

/// Sums of products over all pairs at each lag; lags wrap within the returned n x n.
std::vector<Complex> lagged_products(const Grid& a, const Grid& b, size_t n) {
  std::vector<Complex> fa(n * n), fb(n * n);
  for (size_t y = 0; y < a.height; ++y)
    for (size_t x = 0; x < a.width; ++x) {
      fa[y * n + x] = a.at(x, y);
      fb[y * n + x] = b.at(x, y);
    }
  fft_2d(fa, n);
  fft_2d(fb, n);
  for (size_t i = 0; i < fa.size(); ++i) fa[i] = fa[i] * std::conj(fb[i]);  // forward again: the lag of b against a
  fft_2d(fa, n);
  for (Complex& v : fa) v /= static_cast<double>(n * n);
  return fa;
}

}  // namespace

Spectrum hann_spectrum(const Grid& image, size_t size, size_t stride, const Spectrum* sum) {
  Spectrum out{size, 0, std::vector<double>(size * size, 0.0)};
  if (sum) out = *sum;
  for (double& p : out.power) p *= static_cast<double>(out.windows);
  std::vector<double> hann(size);
  for (size_t i = 0; i < size; ++i)
    hann[i] = 0.5 - 0.5 * std::cos(2.0 * M_PI * (static_cast<double>(i) + 0.5) / static_cast<double>(size));
  std::vector<Complex> window(size * size);
  for (size_t y0 = 0; y0 + size <= image.height; y0 += stride)
    for (size_t x0 = 0; x0 + size <= image.width; x0 += stride) {
      double total = 0.0;
      for (size_t y = 0; y < size; ++y)
        for (size_t x = 0; x < size; ++x) total += image.at(x0 + x, y0 + y);
      total /= static_cast<double>(size * size);
      for (size_t y = 0; y < size; ++y)
        for (size_t x = 0; x < size; ++x) window[y * size + x] = (image.at(x0 + x, y0 + y) - total) * hann[x] * hann[y];
      fft_2d(window, size);
      for (size_t i = 0; i < window.size(); ++i) out.power[i] += std::norm(window[i]);
      ++out.windows;
    }
  for (double& p : out.power) p /= static_cast<double>(std::max<size_t>(out.windows, 1));
  return out;
}

Spectrum prewhitened(const Spectrum& spectrum) {
  const size_t n = spectrum.size;
  std::vector<double> normal(kTerms * kTerms, 0.0), right(kTerms, 0.0);
  const auto used = [&](size_t kx, size_t ky) {
    return std::hypot(static_cast<double>(signed_frequency(kx, n)), static_cast<double>(signed_frequency(ky, n))) >=
               kLeastCycles &&
           spectrum.at(kx, ky) > 0.0;
  };
  const auto terms_at = [&](size_t kx, size_t ky) {
    return smooth_terms(static_cast<double>(signed_frequency(kx, n)), static_cast<double>(signed_frequency(ky, n)));
  };
  for (size_t ky = 0; ky < n; ++ky)
    for (size_t kx = 0; kx < n; ++kx) {
      if (!used(kx, ky)) continue;
      const auto t = terms_at(kx, ky);
      // Every ring counts the same: the many high frequencies must not decide about the few low ones.
      const double weight =
          1.0 / std::hypot(static_cast<double>(signed_frequency(kx, n)), static_cast<double>(signed_frequency(ky, n)));
      for (size_t i = 0; i < kTerms; ++i) {
        right[i] += weight * t[i] * std::log(spectrum.at(kx, ky));
        for (size_t j = 0; j < kTerms; ++j) normal[i * kTerms + j] += weight * t[i] * t[j];
      }
    }
  const std::vector<double> fit = solve(normal, right);
  Spectrum flat = spectrum;
  for (size_t ky = 0; ky < n; ++ky)
    for (size_t kx = 0; kx < n; ++kx) {
      const auto t = terms_at(kx, ky);
      double log_power = 0.0;
      for (size_t i = 0; i < kTerms; ++i) log_power += fit[i] * t[i];
      flat.at(kx, ky) = used(kx, ky) ? spectrum.at(kx, ky) / std::exp(log_power) : 0.0;
    }
  return flat;
}

namespace {

double ratio_at(const Spectrum& spectrum, size_t kx, size_t ky) {
  const size_t n = spectrum.size;
  std::array<double, 81> around{};
  size_t count = 0;
  for (size_t dy = 0; dy < 9; ++dy)
    for (size_t dx = 0; dx < 9; ++dx) {
      const double p = spectrum.at((kx + n + dx - 4) % n, (ky + n + dy - 4) % n);
      if (p > 0.0) around[count++] = p;
    }
  if (count == 0) return 0.0;
  std::nth_element(around.begin(), around.begin() + count / 2, around.begin() + count);
  return spectrum.at(kx, ky) / around[count / 2];
}

template <typename Ratio>
LatticeLine highest(size_t n, double least_cycles, Ratio&& ratio) {
  LatticeLine line;
  for (size_t ky = 0; ky <= n / 2; ++ky)  // the other half is its mirror image
    for (size_t kx = 0; kx < n; ++kx) {
      const long fx = signed_frequency(kx, n), fy = signed_frequency(ky, n);
      if (std::hypot(static_cast<double>(fx), static_cast<double>(fy)) < least_cycles) continue;
      const double found = ratio(kx, ky);
      if (found > line.ratio) line = {found, fx, fy};
    }
  return line;
}

}  // namespace

LatticeLine highest_line(const Spectrum& spectrum, double least_cycles) {
  return highest(spectrum.size, least_cycles, [&](size_t kx, size_t ky) { return ratio_at(spectrum, kx, ky); });
}

LatticeLine highest_true_line(const Spectrum& spectrum, double least_cycles) {
  const Spectrum flat = prewhitened(spectrum);
  return highest(spectrum.size, least_cycles,
                 [&](size_t kx, size_t ky) { return std::min(ratio_at(spectrum, kx, ky), ratio_at(flat, kx, ky)); });
}

Grid autocorrelation(const Grid& image) {
  const Grid flat = without_plane(image);
  const size_t n = power_of_two_above(3 * std::max(image.width, image.height) / 2 + 1);
  const std::vector<Complex> products = lagged_products(flat, flat, n);
  const double variance = products[0].real() / static_cast<double>(image.values.size());
  Grid out(image.width + 1 - image.width % 2, image.height + 1 - image.height % 2);
  for (size_t y = 0; y < out.height; ++y)
    for (size_t x = 0; x < out.width; ++x) {
      const long lx = static_cast<long>(x) - static_cast<long>(out.width / 2);
      const long ly = static_cast<long>(y) - static_cast<long>(out.height / 2);
      const size_t wx = static_cast<size_t>(lx + static_cast<long>(n)) % n;
      const size_t wy = static_cast<size_t>(ly + static_cast<long>(n)) % n;
      const double pairs = static_cast<double>(image.width - static_cast<size_t>(std::abs(lx))) *
                           static_cast<double>(image.height - static_cast<size_t>(std::abs(ly)));
      out.at(x, y) = products[wy * n + wx].real() / (pairs * variance);
    }
  return out;
}

Summit most_prominent(const Grid& map, double distance) {
  // Water falls: islands appear at their summits and merge at passes, where the lower summit's prominence is settled.
  std::vector<size_t> order(map.values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return map.values[a] > map.values[b]; });
  constexpr size_t kNone = ~size_t{0};
  std::vector<size_t> parent(map.values.size(), kNone), summit(map.values.size());
  const auto root = [&](size_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  Summit best;
  const auto settle = [&](size_t top, double pass) {
    const double dx = static_cast<double>(top % map.width) - static_cast<double>(map.width / 2);
    const double dy = static_cast<double>(top / map.width) - static_cast<double>(map.height / 2);
    const double prominence = map.values[top] - pass;
    if (std::hypot(dx, dy) > distance && prominence > best.prominence)
      best = {prominence, map.values[top], std::hypot(dx, dy)};
  };
  for (const size_t i : order) {
    parent[i] = i;
    summit[i] = i;
    const long x = static_cast<long>(i % map.width), y = static_cast<long>(i / map.width);
    // A summit on the rim may go on rising outside: it is no local maximum of the map.
    for (long dy = -1; dy <= 1; ++dy)
      for (long dx = -1; dx <= 1; ++dx) {
        const long nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= static_cast<long>(map.width) || ny >= static_cast<long>(map.height)) continue;
        const size_t j = static_cast<size_t>(ny) * map.width + static_cast<size_t>(nx);
        if (j == i || parent[j] == kNone) continue;
        size_t a = root(i), b = root(j);
        if (a == b) continue;
        if (map.values[summit[a]] > map.values[summit[b]]) std::swap(a, b);
        const size_t lower = summit[a];
        const size_t lx = lower % map.width, ly = lower / map.width;
        if (lx > 0 && ly > 0 && lx + 1 < map.width && ly + 1 < map.height && lower != i) settle(lower, map.values[i]);
        parent[a] = b;
      }
  }
  return best;
}

double percentile(std::vector<double> values, double p) {
  if (values.empty()) return 0.0;
  const auto k = static_cast<long>(p * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<size_t>(k)];
}

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(std::max<size_t>(values.size(), 1));
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const double ma = mean(a), mb = mean(b);
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - ma) * (b[i] - mb);
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

Displacement displacement(const Grid& a, const Grid& b, long reach) {
  const Grid fa = without_plane(a), fb = without_plane(b);
  const size_t n = power_of_two_above(std::max(a.width, a.height) + static_cast<size_t>(reach) + 2);
  const std::vector<Complex> products = lagged_products(fa, fb, n);
  double aa = 0.0, bb = 0.0;
  for (size_t i = 0; i < fa.values.size(); ++i) {
    aa += fa.values[i] * fa.values[i];
    bb += fb.values[i] * fb.values[i];
  }
  const auto at = [&](long dx, long dy) {
    const double pairs = static_cast<double>(static_cast<long>(a.width) - std::abs(dx)) *
                         static_cast<double>(static_cast<long>(a.height) - std::abs(dy));
    const size_t wx = static_cast<size_t>(dx + static_cast<long>(n)) % n;
    const size_t wy = static_cast<size_t>(dy + static_cast<long>(n)) % n;
    return products[wy * n + wx].real() / std::sqrt(aa * bb) * static_cast<double>(fa.values.size()) / pairs;
  };
  Displacement best{0.0, 0.0, -2.0};
  for (long dy = -reach; dy <= reach; ++dy)
    for (long dx = -reach; dx <= reach; ++dx)
      if (at(dx, dy) > best.peak) best = {static_cast<double>(dx), static_cast<double>(dy), at(dx, dy)};
  const auto x = static_cast<long>(best.dx), y = static_cast<long>(best.dy);
  // The top of the parabola through three points.
  const auto offset = [](double before, double here, double after) {
    const double curve = before - 2.0 * here + after;
    return curve < 0.0 ? 0.5 * (before - after) / curve : 0.0;
  };
  best.dx += offset(at(x - 1, y), best.peak, at(x + 1, y));
  best.dy += offset(at(x, y - 1), best.peak, at(x, y + 1));
  return best;
}

}  // namespace nepho::test
