#include "material/constants.hpp"

#include "base/limits.hpp"
#include "base/text.hpp"
#include "material/law_kind.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

enum Constant { youngs, poissons, shear, bulk, lame_first };

constexpr std::array constants{
    ParameterInfo{"youngs_modulus", "Pa", 0.0, infinity,
                  "Young's modulus: stiffness in uniaxial tension at small strain"},
    ParameterInfo{"poissons_ratio", "1", -1.0, 0.5,
                  "Poisson's ratio: lateral contraction per extension at small strain", LowerBound::excluded, 1.0,
                  std::nullopt, UpperBound::included},
    ParameterInfo{"shear_modulus", "Pa", 0.0, infinity, "stiffness in shear at small strain"},
    ParameterInfo{"bulk_modulus", "Pa", 0.0, infinity, "stiffness against volume change at small strain"},
    ParameterInfo{"lame_lambda", "Pa", -infinity, infinity, "first Lame parameter: bulk_modulus - 2/3 shear_modulus"},
};

std::string names_of_parameters(std::span<const ParameterInfo> parameters) {
  std::string names;
  for (const auto& p : parameters) names += (names.empty() ? "" : ", ") + std::string(p.name);
  return names;
}

int place_in(std::span<const ParameterInfo> parameters, std::string_view name) {
  const auto found = std::ranges::find(parameters, name, &ParameterInfo::name);
  return found == parameters.end() ? -1 : static_cast<int>(found - parameters.begin());
}

bool has(const LawInfo& law, Constant c) {
  return place_in(law.parameters, constants[c].name) >= 0;
}

/// Whether the law has two constants of the isotropic solid; otherwise it has one parameter of the volume, or none.
bool takes_two_constants(const LawInfo& law) {
  return has(law, shear) && (has(law, bulk) || has(law, lame_first));
}

/// The one parameter of the volume of an isotropic law, which bulk_modulus or poissons_ratio can replace: the first
/// Lame parameter at rest is this parameter and a number. Empty if there is none.
std::string_view parameter_of_volume(const LawInfo& law) {
  if (takes_two_constants(law) || !law.directions.empty()) return {};
  for (const std::string_view name : {std::string_view("bulk_modulus"), std::string_view("lambda")}) {
    if (place_in(law.parameters, name) >= 0) return name;
  }
  return {};
}

/// One of the constants that laws have for parameters.
template <class T>
T value_of(Constant c, const LameOf<T>& l) {
  if (c == shear) return l.mu;
  if (c == bulk) return l.lambda + 2.0 / 3.0 * l.mu;
  return l.lambda;
}

Lame at_rest_of(std::size_t row, const std::vector<double>& parameters) {
  return ElasticLawSpec{row, parameters}.at_rest().value_or(Lame{});
}
LameOf<Dual<double>> at_rest_of(std::size_t row, const std::vector<Dual<double>>& parameters) {
  const auto at_rest = kind_of(row).dual_at_rest;
  return at_rest == nullptr ? LameOf<Dual<double>>{} : at_rest({parameters});
}

/// mu and lambda from two of the constants by their indices, in ascending order.
template <class T>
LameOf<T> lame_from(int first, const T& a, int second, const T& b) {
  switch (10 * first + second) {
    case 10 * youngs + poissons:
      return {a / (2.0 * (1.0 + b)), a * b / ((1.0 + b) * (1.0 - 2.0 * b))};
    case 10 * youngs + shear:
      return {b, b * (a - 2.0 * b) / (3.0 * b - a)};
    case 10 * youngs + bulk:
      return {3.0 * b * a / (9.0 * b - a), 3.0 * b * (3.0 * b - a) / (9.0 * b - a)};
    case 10 * youngs + lame_first: {
      using std::sqrt;
      const T R = sqrt(T(a * a + 9.0 * b * b + 2.0 * a * b));
      return {0.25 * (a - 3.0 * b + R), b};
    }
    case 10 * poissons + shear:
      return {b, 2.0 * b * a / (1.0 - 2.0 * a)};
    case 10 * poissons + bulk:
      return {1.5 * b * (1.0 - 2.0 * a) / (1.0 + a), 3.0 * b * a / (1.0 + a)};
    case 10 * poissons + lame_first:
      return {b * (1.0 - 2.0 * a) / (2.0 * a), b};
    case 10 * shear + bulk:
      return {a, b - 2.0 / 3.0 * a};
    case 10 * shear + lame_first:
      return {a, b};
    default:
      return {1.5 * (a - b), b};  // bulk, lame_lambda
  }
}

}  // namespace

std::span<const ParameterInfo> elastic_constants() {
  return constants;
}

bool takes(std::size_t row, std::string_view key) {
  const LawInfo& law = elastic_laws()[row];
  const int constant = place_in(constants, key);
  if (constant >= 0 && takes_two_constants(law)) return true;
  if ((constant == poissons || constant == bulk) && !parameter_of_volume(law).empty()) return true;
  return place_in(law.parameters, key) >= 0;
}

bool follows_from_constants(std::size_t row, std::string_view parameter) {
  return place_in(constants, parameter) >= 0 || parameter == parameter_of_volume(elastic_laws()[row]);
}

Lame lame_of(int first, double a, int second, double b) {
  return lame_from(first, a, second, b);
}

std::string equivalents(const Lame& l) {
  return fmt::format("E = {:.4g} Pa, nu = {:.4g}, mu = {:.4g} Pa, K = {:.4g} Pa, lambda = {:.4g} Pa", youngs_modulus(l),
                     poissons_ratio(l), l.mu, bulk_modulus(l), l.lambda);
}

ConstantsRule::ConstantsRule(std::size_t row, std::vector<std::string> keys, const Location& where)
    : row_(row), keys_(std::move(keys)) {
  const LawInfo& law = elastic_laws()[row];
  std::vector<Diagnostic> errors;
  key_of_parameter_.assign(law.parameters.size(), -1);
  const bool two = takes_two_constants(law);
  const std::string_view of_volume = parameter_of_volume(law);
  std::size_t num_given = 0;  // of the constants, or of what may stand for the parameter of the volume
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    const int constant = place_in(constants, keys_[k]), own = place_in(law.parameters, keys_[k]);
    const bool belongs = two ? constant >= 0 : !of_volume.empty() && (constant == bulk || constant == poissons);
    if (belongs || keys_[k] == of_volume) ++num_given;
    if (belongs) {
      constants_.push_back({constant, static_cast<int>(k)});
    } else if (own >= 0) {
      key_of_parameter_[own] = static_cast<int>(k);
    } else {
      errors.push_back(
          {Severity::error, where,
           fmt::format("'{}' is not a parameter of {}, which has {}{}", keys_[k], law.name,
                       names_of_parameters(law.parameters), two ? " (or other two of the elastic constants)" : "")});
    }
  }
  std::ranges::sort(constants_);
  const std::size_t wanted = two ? 2 : of_volume.empty() ? 0 : 1;
  if (num_given != wanted) {
    const std::string given = num_given == 0 ? "none is given" : fmt::format("{} given", num_given);
    errors.push_back({Severity::error, where,
                      two ? fmt::format("{} needs two of {}; {}", law.name, names_of_parameters(constants),
                                        num_given == 1 ? "one is given" : given)
                          : fmt::format("{} needs one of {}bulk_modulus, poissons_ratio; {}", law.name,
                                        of_volume == "lambda" ? "lambda, " : "", given)});
  }
  for (std::size_t p = 0; p < law.parameters.size(); ++p) {
    const bool is_constant =
        law.parameters[p].name == of_volume || (two && place_in(constants, law.parameters[p].name) >= 0);
    if (is_constant || key_of_parameter_[p] >= 0) continue;
    const bool is_needed = std::ranges::find(keys_, law.parameters[p].needed_with) != keys_.end();
    if (law.parameters[p].fallback && !is_needed) continue;
    errors.push_back(
        {Severity::error, where,
         fmt::format("missing key '{}' of {}: {}", law.parameters[p].name, law.name, law.parameters[p].meaning)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
}

template <class T>
std::vector<T> ConstantsRule::parameters(std::span<const T> values) const {
  const LawInfo& law = elastic_laws()[row_];
  std::vector<T> result(law.parameters.size());
  for (std::size_t p = 0; p < result.size(); ++p) {
    const int key = key_of_parameter_[p];
    result[p] = key >= 0 ? values[key] : T(law.parameters[p].fallback.value_or(0.0));
  }
  if (constants_.empty()) return result;
  const auto [first, first_key] = constants_.front();
  if (takes_two_constants(law)) {
    const auto [second, second_key] = constants_.back();
    const LameOf<T> l = lame_from(first, values[first_key], second, values[second_key]);
    for (const Constant c : {shear, bulk, lame_first}) {
      const int p = place_in(law.parameters, constants[c].name);
      if (p >= 0) result[p] = value_of(c, l);
    }
  } else {
    const int p = place_in(law.parameters, parameter_of_volume(law));
    const LameOf<T> rest = at_rest_of(row_, result);  // with this parameter at 0
    const T value = values[first_key];
    if (first == bulk) {
      result[p] = value - (rest.lambda + 2.0 / 3.0 * rest.mu);  // of rest: 0 where the parameter is the modulus itself
    } else {
      result[p] = 2.0 * rest.mu * value / (1.0 - 2.0 * value) - rest.lambda;
    }
  }
  return result;
}

std::vector<double> ConstantsRule::operator()(std::span<const double> values) const {
  return parameters(values);
}

std::vector<Dual<double>> ConstantsRule::operator()(std::span<const Dual<double>> values) const {
  return parameters(values);
}

std::vector<std::string> ConstantsRule::errors(std::span<const double> values) const {
  const LawInfo& law = elastic_laws()[row_];
  std::vector<std::string> found;
  for (std::size_t k = 0; k < keys_.size(); ++k) {
    const int constant = place_in(constants, keys_[k]), own = place_in(law.parameters, keys_[k]);
    const ParameterInfo& p = own >= 0 ? law.parameters[own] : constants[constant];
    if (const auto text = error_in(p, values[k])) found.push_back(*text);
  }
  if (!found.empty()) return found;
  const ElasticLawSpec spec{row_, (*this)(values)};
  if (const auto rest = spec.at_rest()) {
    if (!(rest->mu > 0.0) || !(bulk_modulus(*rest) > 0.0)) {
      found.push_back(fmt::format(
          "these constants of {} make the body unstable at rest: shear modulus {:.4g} Pa, bulk modulus {:.4g} Pa; both "
          "must be above 0",
          law.name, rest->mu, bulk_modulus(*rest)));
    }
  } else {
    for (std::size_t p = 0; p < law.parameters.size(); ++p) {
      if (const auto text = error_in(law.parameters[p], spec.parameters[p])) found.push_back(*text);
    }
  }
  return found;
}

}  // namespace pliant
