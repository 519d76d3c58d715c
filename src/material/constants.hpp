/// From the constants that users give to the parameters of a law.
///
/// A law's own parameters go by their names. Where they are an elastic modulus of the isotropic solid at rest -
/// shear_modulus, bulk_modulus, lame_lambda - users may give any two of
///     youngs_modulus, poissons_ratio, shear_modulus, bulk_modulus, lame_lambda
/// and where bulk_modulus stands alone, because the law has its own stiffness against shear, poissons_ratio in its
/// place.
#pragma once

#include "material/elastic_law.hpp"

#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Constants of the isotropic solid, any two of which determine it. Their rows have the bounds of each.
std::span<const ParameterInfo> elastic_constants();

/// Whether a law (by its row) can be given this key: one of its parameters, or a constant that stands for them.
bool takes(std::size_t row, std::string_view key);

/// The rule that makes the parameters of a law of certain keys: checked once, applied at as many points as there are.
class ConstantsRule {
 public:
  /// `keys` as given. Throws InputError at `where` if they do not determine the law's parameters, or do so twice.
  ConstantsRule(std::size_t row, std::vector<std::string> keys, const Location& where);

  /// The law's parameters from the values of the keys, in their order.
  std::vector<double> operator()(std::span<const double> values) const;
  /// What is wrong with the values; empty if nothing.
  std::vector<std::string> complaints(std::span<const double> values) const;

 private:
  std::size_t row_;
  std::vector<std::string> keys_;
  std::vector<int> key_of_parameter_;           // -1: not given by itself
  std::vector<std::pair<int, int>> constants_;  // given ones: place in elastic_constants(), place in keys
};

/// mu and lambda from two of elastic_constants(), given by their places in it, in ascending order.
Lame lame_of(int first, double first_value, int second, double second_value);

/// E, nu, mu, K and lambda in words: "E = 1 MPa, nu = 0.4, ..." in SI units.
std::string equivalents(const Lame& constants);

}  // namespace pliant
