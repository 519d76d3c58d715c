/// How orders are measured: errors of a motion at two numbers of steps.
#pragma once

#include "petsc/collective.hpp"
#include "time/ode.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test {

inline constexpr double end_time = 2.0;
inline constexpr double slope_tolerance = 0.1;
inline constexpr int num_coarse = 320;  // steps of the coarser of two levels
inline constexpr int num_samples = 5;   // times at which errors are taken, lest one that passes through zero mislead

/// Where the steps end that make up [0, end_time], and those before 0 for an exact start.
using Times = std::function<double(int step, int num_steps)>;

inline double equal(int step, int num_steps) {
  return end_time * step / num_steps;
}

/// Eight steps of different lengths over and over; the longest jump up is by 1.4.
inline double uneven(int step, int num_steps) {
  constexpr std::array<double, 8> length = {1.0, 1.4, 1.7, 1.2, 0.8, 0.5, 0.6, 0.8};
  double offset = 0.0;
  const int period = static_cast<int>(std::floor(step / 8.0));
  for (int i = 0; i < step - 8 * period; ++i) offset += length[static_cast<std::size_t>(i)];
  return end_time * (8.0 * period + offset) / num_steps;
}

inline bool is_sampled(int step, int num_steps) {
  return step % (num_steps / num_samples) == 0;
}

/// Times of the exact states that precede the start.
inline std::vector<double> earlier_times(const Method& method, const Times& times, int num_steps) {
  std::vector<double> earlier;
  for (int r = method.num_steps - 1; r >= 1; --r) earlier.push_back(times(-r, num_steps));
  return earlier;
}

/// Errors of the parts of y by their names, each the largest over entries, ranks and the times looked at.
class Errors {
 public:
  void look(const std::string& part, const std::vector<double>& computed, const std::vector<double>& exact) {
    double& largest = parts_[part];
    largest = std::max(largest, largest_distance(computed, exact));
  }
  void look(const Ode& ode, const State& state) {
    const Values exact = reference(ode, state.time);
    look("q", values_of(state.q.get()), exact.q);
    look("v", values_of(state.v.get()), exact.v);
  }
  const std::map<std::string, double>& parts() const { return parts_; }

 private:
  std::map<std::string, double> parts_;
};

inline void expect_order(const std::string& what, double order, const std::function<Errors(int num_steps)>& errors) {
  const Errors coarse = errors(num_coarse), fine = errors(2 * num_coarse);
  for (const auto& [part, error] : coarse.parts()) {
    const double finer = fine.parts().at(part), slope = std::log2(error / finer);
    EXPECT_NEAR(slope, order, slope_tolerance) << what << ", " << part << ": errors " << error << ", " << finer;
    testing::Test::RecordProperty("order_" + part, std::to_string(slope));
  }
}

}  // namespace pliant::test
