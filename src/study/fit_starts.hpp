/// Where a fit of a material starts: from typical constants that are scaled to the data, and from points around them.
#pragma once

#include "study/fit_material.hpp"
#include "study/fit_problem.hpp"
#include "study/fit_tests.hpp"

#include <functional>
#include <span>
#include <vector>

namespace pliant {

class FitStarts {
 public:
  /// Throws InputError for bounds and initial values of parameters that are not fitted, or that are not admissible.
  FitStarts(const FitConfig& config, const FitMaterial& material, std::span<const MaterialTest> tests);

  /// The parameters that are fitted, with the bounds of the law and of the user.
  const std::vector<FreeParameter>& parameters() const { return parameters_; }
  /// The n-th start: 0 is the first guess, the others fill the space around it evenly. The same every time.
  std::vector<double> operator()(int n) const;

 private:
  void guess(const FitMaterial& material, std::span<const MaterialTest> tests);
  void read_bounds(const FitConfig& config);
  void read_initial(const FitConfig& config);
  std::size_t find(const NamedNode& given, const std::string& section) const;
  double around(std::size_t j, double part) const;

  std::vector<FreeParameter> parameters_;
  std::vector<double> first_;
  std::vector<bool> has_bounds_;         ///< both, by the user
  std::vector<double> earliest_latest_;  ///< of the data in time [s]
};

}  // namespace pliant
