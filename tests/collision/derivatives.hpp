/// Random points, and derivatives against central differences.
#pragma once

#include "collision/expansion.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include <gtest/gtest.h>

namespace pliant::testing_collision {

template <int N>
using Points = std::array<Vector3<double>, N>;

/// Uniform in (-size, size)^3.
class RandomPoints {
 public:
  explicit RandomPoints(unsigned seed) : engine_(seed) {}
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  Vector3<double> point(double size = 1.0) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  template <int N>
  Points<N> points(double size = 1.0) {
    Points<N> x;
    for (auto& p : x) p = point(size);
    return x;
  }

 private:
  std::mt19937 engine_;
};

/// max |gradient| and max |Hessian|.
template <int N>
double size_of_gradient(const Expansion<N>& f) {
  double most = 0.0;
  for (const auto& g : f.gradient) most = std::max({most, std::abs(g[0]), std::abs(g[1]), std::abs(g[2])});
  return most;
}
template <int N>
double size_of_hessian(const Expansion<N>& f) {
  double most = 0.0;
  for (const auto& block : f.blocks) {
    for (const double entry : block.a) most = std::max(most, std::abs(entry));
  }
  return most;
}

/// The gradient of f against differences of its value, and its Hessian against those of its gradient; the errors in
/// parts of the largest entry.
struct DerivativeErrors {
  double gradient = 0.0, hessian = 0.0;
};
template <int N, class F>
DerivativeErrors compare_with_differences(const F& f, const Points<N>& x, double step) {
  const Expansion<N> at = f(x);
  const double gradient_size = size_of_gradient(at), hessian_size = size_of_hessian(at);
  EXPECT_GT(gradient_size, 0.0);
  EXPECT_GT(hessian_size, 0.0);
  DerivativeErrors errors;
  for (int j = 0; j < N; ++j) {
    for (int q = 0; q < 3; ++q) {
      Points<N> right = x, left = x;
      right[j][q] += step;
      left[j][q] -= step;
      const double width = right[j][q] - left[j][q];
      const Expansion<N> f_right = f(right), f_left = f(left);
      const double slope = (f_right.value - f_left.value) / width;
      errors.gradient = std::max(errors.gradient, std::abs(slope - at.gradient[j][q]) / gradient_size);
      for (int i = 0; i < N; ++i) {
        for (int p = 0; p < 3; ++p) {
          const double second = (f_right.gradient[i][p] - f_left.gradient[i][p]) / width;
          errors.hessian = std::max(errors.hessian, std::abs(second - at.block(i, j)(p, q)) / hessian_size);
        }
      }
    }
  }
  return errors;
}

}  // namespace pliant::testing_collision
