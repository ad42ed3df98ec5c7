#include "clouds/volume_tools.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace nepho {
namespace {

size_t texels_of(uint32_t size) { return size_t{size} * size * size; }

template <size_t n>
double polynomial(const double (&coefficients)[n], double x) {
  double sum = 0.0;
  for (const double c : coefficients) sum = sum * x + c;
  return sum;
}

struct Keyed {
  uint32_t key, index;
};

/// Values with their places, in rising order. A radix sort: ten times as fast as a comparison sort here.
std::vector<Keyed> sorted(const std::vector<float>& values) {
  std::vector<Keyed> items(values.size()), other(values.size());
  for (uint32_t i = 0; i < values.size(); ++i) {
    const auto bits = std::bit_cast<uint32_t>(values[i] + 0.0f);  // + 0: no negative zero
    items[i] = {bits & 0x80000000u ? ~bits : bits | 0x80000000u, i};
  }
  for (uint32_t shift = 0; shift < 33; shift += 11) {
    size_t start[2049] = {};
    for (const Keyed& item : items) ++start[((item.key >> shift) & 2047u) + 1];
    for (size_t d = 1; d < 2049; ++d) start[d] += start[d - 1];
    for (const Keyed& item : items) other[start[(item.key >> shift) & 2047u]++] = item;
    items.swap(other);
  }
  return items;
}

}  // namespace

double probit(double share) {
  NEPHO_ASSERT_OP(share, >, 0.0);
  NEPHO_ASSERT_OP(share, <, 1.0);
  const double q = share - 0.5;
  if (std::abs(q) <= 0.425) {
    constexpr double a[] = {2509.0809287301226727, 33430.575583588128105, 67265.770927008700853, 45921.953931549871457,
                            13731.693765509461125, 1971.5909503065514427, 133.14166789178437745, 3.387132872796366608};
    constexpr double b[] = {5226.495278852545925,  28729.085735721942674, 39307.89580009271061,  21213.794301586595867,
                            5394.1960214247511077, 687.1870074920579083,  42.313330701600911252, 1.0};
    const double r = 0.180625 - q * q;
    return q * polynomial(a, r) / polynomial(b, r);
  }
  const double r = std::sqrt(-std::log(std::min(share, 1.0 - share)));
  double z = 0.0;
  if (r <= 5.0) {
    constexpr double c[] = {7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177,
                            1.27045825245236838258,   3.64784832476320460504,   5.7694972214606914055,
                            4.6303378461565452959,    1.42343711074968357734};
    constexpr double d[] = {
        1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966, 0.14810397642748007459,
        0.68976733498510000455,    1.6763848301838038494,   2.05319162663775882187,   1.0};
    z = polynomial(c, r - 1.6) / polynomial(d, r - 1.6);
  } else {
    constexpr double e[] = {2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386,
                            0.026532189526576123093,   0.29656057182850489123,    1.7848265399172913358,
                            5.4637849111641143699,     6.6579046435011037772};
    constexpr double f[] = {
        2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5, 7.868691311456132591e-4,
        0.0148753612908506148525,   0.13692988092273580531,   0.59983220655588793769,   1.0};
    z = polynomial(e, r - 5.0) / polynomial(f, r - 5.0);
  }
  return q < 0.0 ? -z : z;
}

bool normalise_volume(std::vector<float>& values, bool gaussian) {
  if (values.empty() || std::all_of(values.begin(), values.end(), [&](float v) { return v == values[0]; }))
    return false;
  const auto count = static_cast<double>(values.size());
  if (gaussian) {
    const std::vector<Keyed> items = sorted(values);
    for (size_t first = 0; first < items.size();) {
      size_t end = first + 1;
      while (end < items.size() && items[end].key == items[first].key) ++end;
      // Equal values (of 8-bit files) stay equal.
      const auto z = static_cast<float>(probit(static_cast<double>(first + end) / (2.0 * count)));
      for (; first < end; ++first) values[items[first].index] = z;
    }
  }
  double mean = 0.0, square = 0.0;
  for (const float v : values) mean += v;
  mean /= count;
  for (const float v : values) square += (v - mean) * (v - mean);
  const double scale = 1.0 / std::sqrt(square / count);
  for (float& v : values) v = static_cast<float>((v - mean) * scale);
  return true;
}

void decorrelate(std::vector<std::vector<float>>& planes) {
  for (size_t c = 0; c < planes.size(); ++c) {
    normalise_volume(planes[c], false);
    for (size_t d = 0; d < c; ++d) {
      double product = 0.0;
      for (size_t i = 0; i < planes[c].size(); ++i) product += static_cast<double>(planes[c][i]) * planes[d][i];
      const auto common = static_cast<float>(product / static_cast<double>(planes[c].size()));
      for (size_t i = 0; i < planes[c].size(); ++i) planes[c][i] -= common * planes[d][i];
    }
    normalise_volume(planes[c], false);
  }
}

std::vector<float> half_volume(const std::vector<float>& values, uint32_t size) {
  if (size <= 1) return values;
  const uint32_t half = size / 2;
  std::vector<float> next(texels_of(half));
  for (size_t z = 0, i = 0; z < half; ++z)
    for (size_t y = 0; y < half; ++y)
      for (size_t x = 0; x < half; ++x, ++i) {
        float sum = 0.0f;
        for (size_t k = 0; k < 8; ++k)
          sum += values[((2 * z + (k >> 2)) * size + 2 * y + ((k >> 1) & 1)) * size + 2 * x + (k & 1)];
        next[i] = sum / 8.0f;
      }
  return next;
}

std::array<std::vector<float>, 3> curl_of(const std::array<std::vector<float>, 3>& potential, uint32_t size) {
  // Central difference along an axis, around the edges.
  const auto derivative = [&](const std::vector<float>& of, size_t axis) {
    const size_t stride = axis == 0 ? 1 : axis == 1 ? size : size_t{size} * size;
    std::vector<float> result(of.size());
    for (size_t i = 0; i < of.size(); ++i) {
      const size_t at = i / stride % size, row = i - at * stride;
      result[i] = of[row + (at + 1) % size * stride] - of[row + (at + size - 1) % size * stride];
    }
    return result;
  };
  // Component c is scale[b] d(potential b)/da - scale[a] d(potential a)/db.
  struct Component {
    size_t a, b;
    std::vector<float> first, second;
    double first2 = 0.0, second2 = 0.0, product = 0.0;  // means
  };
  std::vector<Component> components;
  for (size_t c = 0; c < 3; ++c) {
    const size_t a = (c + 1) % 3, b = (c + 2) % 3;
    Component& k = components.emplace_back(Component{a, b, derivative(potential[b], a), derivative(potential[a], b)});
    for (size_t i = 0; i < k.first.size(); ++i) {
      k.first2 += double{k.first[i]} * k.first[i] / static_cast<double>(k.first.size());
      k.second2 += double{k.second[i]} * k.second[i] / static_cast<double>(k.first.size());
      k.product += double{k.first[i]} * k.second[i] / static_cast<double>(k.first.size());
    }
  }
  // Scales of the potentials that give every component the variance 1: a component by itself could not be scaled
  // without making a divergence. Variances are nearly sums of two squares of scales; repeated until they are 1.
  double square[3] = {1.0, 1.0, 1.0};
  for (int round = 0; round < 30; ++round) {
    double excess[3];
    for (size_t c = 0; c < 3; ++c) {
      const Component& k = components[c];
      const double variance =
          square[k.b] * k.first2 + square[k.a] * k.second2 - 2.0 * std::sqrt(square[k.a] * square[k.b]) * k.product;
      excess[c] = 1.0 / std::max(variance, 1e-30);
    }
    const double sum = excess[0] + excess[1] + excess[2];
    for (size_t c = 0; c < 3; ++c) square[c] *= std::max(sum - 2.0 * excess[c], 0.1 * sum);
  }
  std::array<std::vector<float>, 3> curl;
  for (size_t c = 0; c < 3; ++c) {
    const Component& k = components[c];
    const double scale_a = std::sqrt(square[k.a]), scale_b = std::sqrt(square[k.b]);
    for (size_t i = 0; i < k.first.size(); ++i)
      curl[c].push_back(static_cast<float>(scale_b * k.first[i] - scale_a * k.second[i]));
  }
  return curl;
}

double mean_square_between(const std::vector<float>& values, uint32_t size) {
  // Over a stretch from a to b: the mean of ((1 - t) a + t b)^2 is (a^2 + a b + b^2) / 3. Summed over neighbours along
  // an axis that is v times (prev + 4 v + next) / 6; axes one after the other.
  std::vector<float> blurred = values, row(size);
  for (size_t stride = 1; stride < values.size(); stride *= size)
    for (size_t block = 0; block < values.size(); block += stride * size)
      for (size_t first = block; first < block + stride; ++first) {
        for (size_t k = 0; k < size; ++k) row[k] = blurred[first + k * stride];
        for (size_t k = 0; k < size; ++k)
          blurred[first + k * stride] =
              (row[k == 0 ? size - 1 : k - 1] + 4.0f * row[k] + row[k + 1 == size ? 0 : k + 1]) / 6.0f;
      }
  double sum = 0.0;
  for (size_t i = 0; i < values.size(); ++i) sum += static_cast<double>(values[i]) * blurred[i];
  return sum / static_cast<double>(values.size());
}

size_t bytes_of_mips(uint32_t size, uint32_t bytes_per_texel) {
  size_t sum = 0;
  for (uint32_t n = size; n >= 1; n /= 2) sum += texels_of(n) * bytes_per_texel;
  return sum;
}

MippedVolume make_mips(std::vector<std::vector<float>> planes, uint32_t size, uint32_t bytes_per_channel) {
  NEPHO_ASSERT(std::has_single_bit(size));
  const size_t channels = planes.size();
  MippedVolume volume;
  volume.size = size;
  volume.texels.resize(bytes_of_mips(size, static_cast<uint32_t>(channels) * bytes_per_channel));
  size_t offset = 0;
  std::vector<double> finest(channels);
  for (uint32_t n = size; n >= 1; n /= 2) {
    for (size_t c = 0; c < channels; ++c) {
      NEPHO_ASSERT_OP(planes[c].size(), ==, texels_of(n));
      for (size_t i = 0; i < texels_of(n); ++i) {
        const float unit = std::clamp(0.5f + planes[c][i] / (2.0f * MippedVolume::kRange), 0.0f, 1.0f);
        std::byte* to = &volume.texels[offset + (i * channels + c) * bytes_per_channel];
        if (bytes_per_channel == 1) {
          *to = static_cast<std::byte>(static_cast<int>(unit * 255.0f + 0.5f));
        } else {
          const auto word = static_cast<uint16_t>(unit * 65535.0f + 0.5f);
          std::memcpy(to, &word, 2);
        }
      }
      const double square = mean_square_between(planes[c], n);
      if (n == size) finest[c] = std::max(square, 1e-30);
      volume.variances.push_back(static_cast<float>(square / finest[c]));
      planes[c] = half_volume(planes[c], n);
    }
    offset += texels_of(n) * channels * bytes_per_channel;
  }
  return volume;
}

}  // namespace nepho
