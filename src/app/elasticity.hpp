/// The elastic laws of the bodies, as the input describes them.
#pragma once

#include "app/config.hpp"
#include "material/constants.hpp"

#include <array>
#include <string>

namespace pliant {

/// A body's law as a function of the reference position.
class ElasticityRule {
 public:
  /// Throws InputError if the constants do not determine the law.
  explicit ElasticityRule(const ElasticityConfig& config);

  bool is_uniform() const { return is_uniform_; }
  /// Throws InputError if the constants are not admissible there.
  ElasticLawSpec law_at(const std::array<double, 3>& X) const;
  /// Its kind, for what does not depend on the constants.
  const ElasticLawSpec& kind() const { return kind_; }

 private:
  const ElasticityConfig& config_;
  ElasticLawSpec kind_;
  ConstantsRule rule_;
  bool is_uniform_;
};

/// The law and its constants in words, with what is equivalent to them.
std::string describe(const ElasticityConfig& config);

std::string describe(const ElasticLawSpec& law);

/// Stiffness against the fastest and the slowest wave in a body at rest, density times the squared speed [Pa].
struct WaveModuli {
  double largest;
  double smallest;
};
WaveModuli wave_moduli(const ElasticLawSpec& law);

}  // namespace pliant
