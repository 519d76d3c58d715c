/// Backward differentiation formulas on arbitrary times: y_{n+1} = sum_r alpha_r y_{n+1-r} + beta dt f_{n+1}.
#pragma once

#include "time/step.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace pliant {

/// The most past states a formula may have: with seven or more it is not zero-stable.
inline constexpr int max_bdf_steps = 6;

/// The weights of a formula. Allocates nothing: it is made in every step.
struct BdfWeights {
  std::array<double, max_bdf_steps> values{};  ///< alpha, filled up with zeros
  std::size_t num_steps = 1;                   ///< past states in the formula
  double beta = 1.0;
  /// alpha_1 multiplies y_n.
  std::span<const double> alpha() const { return std::span(values).first(num_steps); }
};

/// Whether the step and those between the past times (newest first) are equal to rounding.
bool are_equal_steps(std::span<const double> past_times, const Step& step);

/// Weights of the formula through y_{n+1} and the states at `past_times` (newest first, strictly falling, at most
/// max_bdf_steps of them). Steps that are equal to rounding get the weights of equal steps, to the last bit.
BdfWeights bdf_weights(std::span<const double> past_times, const Step& step);

/// Whether bdf_max_growth is a proven bound: up to three past states.
bool has_known_growth(int num_steps);

/// Ratio of successive steps up to which the formula with `num_steps` past states is zero-stable, whatever the sequence
/// of steps: none for 1, 1 + sqrt 2 for 2, 1.5 (1.53 rounded down) for 3. Source: Calvo, Grande, Grigorieff 1990, "On
/// the zero stability of the variable order variable stepsize BDF-formulas". 1 for more states.
double bdf_max_growth(int num_steps);

/// How many of the past states may be used for the step: as many as possible without exceeding the limit of any ratio
/// of successive steps in the formula. At least 1.
int num_usable_states(std::span<const double> past_times, const Step& step);

}  // namespace pliant
