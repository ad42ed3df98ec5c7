#pragma once
#include <vector>

namespace nepho {

/// One abscissa of a quadrature and its weight.
struct Node {
  double x, weight;
};

/// Gauss-Legendre with 8 nodes in each panel between the given borders.
inline std::vector<Node> gauss(const std::vector<double>& borders) {
  constexpr double x[4] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double w[4] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  std::vector<Node> nodes;
  for (size_t p = 0; p + 1 < borders.size(); ++p) {
    const double middle = 0.5 * (borders[p] + borders[p + 1]), half = 0.5 * (borders[p + 1] - borders[p]);
    for (int i = 0; i < 4; ++i)
      for (const double sign : {-1.0, 1.0}) nodes.push_back({middle + sign * half * x[i], half * w[i]});
  }
  return nodes;
}

}  // namespace nepho
