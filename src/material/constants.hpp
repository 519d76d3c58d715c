/// From the constants that users give to the parameters of a law.
///
/// Users give a law's own parameters by their names. If the law has elastic constants of the isotropic solid at rest
/// (shear_modulus, bulk_modulus, lame_lambda), users may give any two of
///     youngs_modulus, poissons_ratio, shear_modulus, bulk_modulus, lame_lambda.
/// If an isotropic law has shear stiffnesses of its own and one parameter of the volume (bulk_modulus, lambda),
/// bulk_modulus or poissons_ratio at small strain may replace that one.
#pragma once

#include "base/dual.hpp"
#include "material/elastic_law.hpp"

#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// The constants of the isotropic solid, any two of which determine it, with their bounds.
std::span<const ParameterInfo> elastic_constants();

/// Whether a law (by its row) accepts this key: one of its parameters, or a constant that determines them.
bool takes(std::size_t row, std::string_view key);

/// Whether elastic_constants() determine this parameter of a law.
bool follows_from_constants(std::size_t row, std::string_view parameter);

/// The rule that converts the values of certain keys to the parameters of a law: checked once, applied at every point.
class ConstantsRule {
 public:
  /// `keys` as given. Throws InputError at `where` if they do not determine the law's parameters, or overdetermine
  /// them.
  ConstantsRule(std::size_t row, std::vector<std::string> keys, const Location& where);

  /// The law's parameters from the values of the keys, in their order.
  std::vector<double> operator()(std::span<const double> values) const;
  /// The same with their derivatives.
  std::vector<Dual<double>> operator()(std::span<const Dual<double>> values) const;
  /// Messages for values that are not admissible; empty if all are.
  std::vector<std::string> errors(std::span<const double> values) const;

 private:
  template <class T>
  std::vector<T> parameters(std::span<const T> values) const;

  std::size_t row_;
  std::vector<std::string> keys_;
  std::vector<int> key_of_parameter_;           // -1: not given directly
  std::vector<std::pair<int, int>> constants_;  // given ones: index in elastic_constants(), index in keys
};

/// mu and lambda from two of elastic_constants(), given by their indices in it, in ascending order.
Lame lame_of(int first, double first_value, int second, double second_value);

/// E, nu, mu, K and lambda as text, in SI units: "E = 1e+06 Pa, nu = 0.4, ...".
std::string equivalents(const Lame& constants);

}  // namespace pliant
