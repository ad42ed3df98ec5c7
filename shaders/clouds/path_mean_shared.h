// Statistics of the paths of a ray, for C++ and GLSL.
#ifndef NEPHO_CLOUDS_PATH_MEAN_SHARED_H
#define NEPHO_CLOUDS_PATH_MEAN_SHARED_H
#include "common/shared.h"
SHARED_BEGIN

// Of a value of paths.
struct MeanOf {
  float mean;
  float squares;  // sum of squared differences from the mean
};

struct PathMean {
  uint paths;
  MeanOf sunlit;   // PathResult::sunlit.x
  MeanOf escaped;  // PathResult::weight.x
};

// Of two sets of n and m paths together (Chan, Golub and LeVeque 1983).
SHARED_FN MeanOf means_joined(MeanOf a, float n, MeanOf b, float m) {
  float share = m / (n + m), apart = b.mean - a.mean;
  MeanOf all;
  all.mean = a.mean + apart * share;
  all.squares = a.squares + b.squares + apart * apart * (n * share);
  return all;
}

SHARED_FN PathMean path_means_joined(PathMean a, PathMean b) {
  if (b.paths == 0u) return a;
  float n = float(a.paths), m = float(b.paths);
  PathMean all;
  all.paths = a.paths + b.paths;
  all.sunlit = means_joined(a.sunlit, n, b.sunlit, m);
  all.escaped = means_joined(a.escaped, n, b.escaped, m);
  return all;
}

SHARED_END
#endif
