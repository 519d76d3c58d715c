#include "time/bdf.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

/// s_r = (t_{n+1} - t_{n+1-r}) / dt, r = 1..l; exactly r if the steps are equal to rounding.
std::array<double, max_bdf_steps> distances(std::span<const double> past_times, const Step& step) {
  const bool equal = are_equal_steps(past_times, step);
  std::array<double, max_bdf_steps> s{};
  for (std::size_t r = 0; r < past_times.size(); ++r) {
    s[r] = equal ? static_cast<double>(r + 1) : 1.0 + (past_times.front() - past_times[r]) / step.dt;
  }
  return s;
}

}  // namespace

bool are_equal_steps(std::span<const double> past_times, const Step& step) {
  const double rounding = 8 * std::numeric_limits<double>::epsilon() * std::abs(step.time);
  bool equal = true;
  for (std::size_t r = 0; r < past_times.size(); ++r) {
    const double past = past_times.front() - past_times[r];
    equal = equal && std::abs(past - static_cast<double>(r) * step.dt) <= rounding;
  }
  return equal;
}

// The polynomial p through y_{n+1} and the past states has p'(t_{n+1}) = f_{n+1}. With the Lagrange polynomials L_0 (of
// t_{n+1}) and L_r, whose derivatives at t_{n+1} are, for dt = 1,
//     L_0' = sum_r 1/s_r,   L_r' = -1/s_r prod_{m != r} s_m / (s_m - s_r),
// it follows that alpha_r = -L_r' / L_0' and beta = 1 / L_0'.
BdfWeights bdf_weights(std::span<const double> past_times, const Step& step) {
  assert(!past_times.empty() && past_times.size() <= max_bdf_steps);
  const auto all = distances(past_times, step);
  const std::span s = std::span(all).first(past_times.size());
  double dL0 = 0.0;
  for (double s_r : s) dL0 += 1.0 / s_r;
  BdfWeights weights{{}, s.size(), 1.0 / dL0};
  for (std::size_t r = 0; r < s.size(); ++r) {
    double alpha = 1.0 / (dL0 * s[r]);
    for (std::size_t m = 0; m < s.size(); ++m) {
      if (m != r) alpha *= s[m] / (s[m] - s[r]);
    }
    weights.values[r] = alpha;
  }
  return weights;
}

bool has_known_growth(int num_steps) {
  return num_steps <= 3;
}

double bdf_max_growth(int num_steps) {
  assert(num_steps >= 1 && num_steps <= max_bdf_steps);
  switch (num_steps) {
    case 1:
      return std::numeric_limits<double>::infinity();
    case 2:
      return 1.0 + std::sqrt(2.0);
    case 3:
      return 1.5;
    default:
      return 1.0;
  }
}

int num_usable_states(std::span<const double> past_times, const Step& step) {
  // The formula of l states involves the ratios of l successive steps.
  const auto is_stable = [&](std::size_t l) {
    double newer = step.dt;
    for (std::size_t r = 0; r + 1 < l; ++r) {
      const double older = past_times[r] - past_times[r + 1];
      if (newer > older * bdf_max_growth(static_cast<int>(l)) * (1.0 + 1e-9)) return false;  // 1e-9: rounding of times
      newer = older;
    }
    return true;
  };
  std::size_t l = std::min(past_times.size(), static_cast<std::size_t>(max_bdf_steps));
  while (l > 1 && !is_stable(l)) --l;
  return static_cast<int>(l);
}

}  // namespace pliant
