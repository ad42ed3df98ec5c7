#pragma once
#include <cstddef>
#include <vector>

namespace nepho::test {

/// An image of numbers; row 0 first.
struct Grid {
  size_t width = 0, height = 0;
  std::vector<double> values;
  Grid() = default;
  Grid(size_t w, size_t h) : width(w), height(h), values(w * h) {}
  double& at(size_t x, size_t y) { return values[y * width + x]; }
  double at(size_t x, size_t y) const { return values[y * width + x]; }
};

/// Power spectrum, size x size ordinates; (0, 0) is the mean, frequencies above size / 2 are negative ones.
struct Spectrum {
  size_t size = 0;     ///< a power of two
  size_t windows = 0;  ///< that were averaged
  std::vector<double> power;
  double& at(size_t kx, size_t ky) { return power[ky * size + kx]; }
  double at(size_t kx, size_t ky) const { return power[ky * size + kx]; }
};

/// Welch's estimate: mean of the periodograms of windows `size` x `size` (a power of two), mean removed, times a Hann
/// function along both axes, `stride` apart. Adds to `sum` where that is given, so that several images make one
/// estimate.
Spectrum hann_spectrum(const Grid& image, size_t size, size_t stride, const Spectrum* sum = nullptr);

/// Ordinates divided by a smooth surface fitted to their logarithm: a polynomial in the logarithms of |kx| and |ky|
/// (degree 4, with cross terms, and one term for the quadrant). A steep or stretched spectrum becomes flat; what is as
/// narrow as a lattice's line stays. Ordinates below two cycles a window are left out: their power is the window's.
Spectrum prewhitened(const Spectrum& spectrum);

/// The ordinate that stands highest above the median of its neighbourhood.
struct LatticeLine {
  double ratio = 0.0;   ///< ordinate / median of its 9 x 9 neighbourhood (itself among them)
  long kx = 0, ky = 0;  ///< cycles per window
};
/// `least_cycles`: ordinates with fewer cycles a window are no candidates.
LatticeLine highest_line(const Spectrum& spectrum, double least_cycles);
/// The same where an ordinate's ratio is the smaller of the raw and the prewhitened one: slopes make only the former
/// large, misfits of the smooth surface only the latter, lines both.
LatticeLine highest_true_line(const Spectrum& spectrum, double least_cycles);

/// Autocorrelation for lags up to half the image's sides, 1 at lag 0, of the image with mean and plane removed; each
/// lag divided by the number of its pairs. Pixel (x, y) is the lag (x - width / 2, y - height / 2).
Grid autocorrelation(const Grid& image);

/// The most prominent local maximum of a map farther than `distance` pixels from the middle. Prominence: height above
/// the highest pass to higher ground.
struct Summit {
  double prominence = 0.0, height = 0.0;
  double distance = 0.0;  ///< of the middle, px
};
Summit most_prominent(const Grid& map, double distance);

/// Value that the share `p` (0..1) of the values does not exceed.
double percentile(std::vector<double> values, double p);

/// Pearson's.
double correlation(const std::vector<double>& a, const std::vector<double>& b);
double mean(const std::vector<double>& values);

/// Displacement (dx, dy), in pixels, interpolated, that carries `a` to `b`: where their cross-correlation is highest,
/// no farther than `reach` pixels along either axis; `peak` is the correlation there.
struct Displacement {
  double dx = 0.0, dy = 0.0, peak = 0.0;
};
Displacement displacement(const Grid& a, const Grid& b, long reach);

}  // namespace nepho::test
