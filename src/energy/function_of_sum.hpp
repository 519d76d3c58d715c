/// Terms that are functions of one number summed over all ranks, such as the volume of a cavity.
#pragma once

#include "energy/term.hpp"

namespace pliant {

/// Phi = f(S), S a sum over the facets (or cells) of all ranks. Every rank needs the whole S before it can add its part
/// of the gradient f' dS; and the Hessian f' d2S + f'' dS dS^T has a rank-one term that couples all unknowns
/// of S. The sum of the terms therefore adds up S, and gives it to the term in LocalStage::sum; `add_hessian` adds
/// the first part of the Hessian, and the solver treats the second by its factors.
class FunctionOfSum {
 public:
  virtual ~FunctionOfSum() = default;

  /// This rank's part of S(q0) and of S(q) - S(q0), the latter accurate relative to the change. Uses
  /// only `q0` of the stage and, if it couples pairs too, `near`.
  virtual SumOverRanks part(const LocalStage& stage, std::span<const double> q) const = 0;

  /// f(S(q)) - f(S(q0)) [J], the same on every rank: EnergyTerm::value of all of them. +inf where a barrier is crossed.
  virtual double value_of_sum(const LocalStage& stage) const = 0;
  /// EnergyTerm::energy_at of all ranks at S [J].
  virtual double energy_of_sum(const Instant& at, double S) const = 0;
  /// f'' at the stage's sum, >= 0.
  virtual double curvature(const LocalStage& stage) const = 0;
  /// g += dS/dq, rows of owned nodes complete.
  virtual void add_gradient_of_sum(const LocalStage& stage, std::span<const double> q, std::span<double> g) const = 0;
};

}  // namespace pliant
