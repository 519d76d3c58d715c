#include "study/fit_material.hpp"

#include "base/dual_math.hpp"
#include "base/limits.hpp"
#include "base/text.hpp"
#include "material/parameter_slope.hpp"
#include "material/viscosity_registry.hpp"
#include "material/volume_split.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::array elastic_pair{"youngs_modulus", "poissons_ratio", "shear_modulus", "bulk_modulus", "lame_lambda"};

bool has(std::span<const ParameterInfo> parameters, std::string_view name) {
  return std::ranges::find(parameters, name, &ParameterInfo::name) != parameters.end();
}

bool is_one_of_pair(std::string_view key) {
  return std::ranges::find(elastic_pair, key) != elastic_pair.end();
}

/// The number at the end of a name, 0 if there is none.
int term_of(std::string_view name) {
  std::size_t digits = name.size();
  while (digits > 0 && std::isdigit(static_cast<unsigned char>(name[digits - 1])) != 0) --digits;
  int number = 0;
  for (; digits < name.size(); ++digits) number = 10 * number + (name[digits] - '0');
  return number;
}

/// The term of a law that a parameter belongs to, if the law offers terms to choose from, each a modulus and an
/// exponent that it needs; else 0.
int choosable_term_of(const LawInfo& law, const ParameterInfo& parameter) {
  const int term = term_of(parameter.name);
  const bool has_exponent = std::ranges::any_of(law.parameters, [&](const ParameterInfo& p) {
    return p.fallback && !p.needed_with.empty() && term_of(p.name) == term;
  });
  return parameter.fallback && has_exponent ? term : 0;
}

/// How many terms a law offers to choose from; 0 if its terms are fixed.
int most_terms(const LawInfo& law) {
  int most = 0;
  for (const ParameterInfo& p : law.parameters) most = std::max(most, choosable_term_of(law, p));
  return most;
}

/// Keeps a value away from bounds that are not admissible themselves.
FitParameter parameter_from(const ParameterInfo& info, std::string name) {
  constexpr double margin = 1e-9;
  FitParameter p{std::move(name), std::string(info.unit), info.lower, info.upper, info.typical};
  const double size = std::max(std::abs(info.typical), margin);
  if (info.lower_bound == LowerBound::excluded && std::isfinite(p.lower)) p.lower += margin * size;
  if (std::isfinite(p.upper)) p.upper -= margin * std::max(std::abs(p.upper), margin);
  return p;
}

const ParameterInfo& info_of_constant(const LawInfo& law, std::string_view key) {
  const auto own = std::ranges::find(law.parameters, key, &ParameterInfo::name);
  if (own != law.parameters.end()) return *own;
  return *std::ranges::find(elastic_constants(), key, &ParameterInfo::name);
}

/// Which constants of the isotropic solid are unknown, where a law has two (a shear and a bulk modulus).
std::vector<std::string> unknown_pair(const std::vector<std::string>& held) {
  if (held.empty()) return {"shear_modulus", "bulk_modulus"};
  if (held.size() > 1) return {};
  if (held.front() == "shear_modulus") return {"bulk_modulus"};
  return {held.front() == "youngs_modulus" ? "poissons_ratio" : "shear_modulus"};
}

std::size_t row_of_law(const std::string& model) {
  const auto laws = elastic_laws();
  return static_cast<std::size_t>(std::ranges::find(laws, model, &LawInfo::name) - laws.begin());
}

/// Why a held constant does not go with an incompressible material; empty if it does.
void refuse_with_incompressible(const FitMaterialConfig& material, const ElasticLawSpec& kind) {
  if (!split_volume(kind)) {
    throw InputError(material.where,
                     fmt::format("{} has no incompressible limit; give a 'poissons_ratio' instead of 'incompressible', "
                                 "or choose one of {}",
                                 material.model, names_of_split_laws()));
  }
  for (const HeldConstant& held : material.held) {
    const bool is_stiffness = held.key == "shear_modulus" && has(kind.info().parameters, held.key);
    if (!is_one_of_pair(held.key) || is_stiffness) continue;
    throw InputError(held.where, fmt::format("'{}' does not go with 'incompressible: true'; {}", held.key,
                                             held.key == "youngs_modulus" ? "give a third of it as 'shear_modulus'"
                                                                          : "leave one of the two out"));
  }
}

}  // namespace

FitMaterial::FitMaterial(const FitMaterialConfig& material, const std::optional<FitViscosityConfig>& viscosity)
    : kind_(typical_law(row_of_law(material.model))), is_incompressible_(material.is_incompressible) {
  kind_.volumetric = material.volumetric;
  if (is_incompressible_) refuse_with_incompressible(material, kind_);
  add_constants(material);
  if (viscosity) add_branches(*viscosity);
  for (std::size_t n = 0; n < parameters_.size(); ++n) {
    if (parameters_[n].is_free) free_.push_back(n);
  }
}

void FitMaterial::add_constants(const FitMaterialConfig& material) {
  const LawInfo& law = kind_.info();
  const auto& held = material.held;
  const int most = most_terms(law);
  if (material.terms && most == 0) {
    throw InputError(material.where, fmt::format("'terms' does not go with {}, whose terms are fixed; give a constant "
                                                 "as 0 to leave it out, as in '{{model: yeoh, c30: 0 Pa}}'",
                                                 material.model));
  }
  if (material.terms.value_or(1) > std::max(most, 1)) {
    throw InputError(material.where, fmt::format("'terms' of {} is at most {}", material.model, most));
  }
  const auto add_free = [&](const std::string& key) {
    if (std::ranges::find(parameters_, key, &FitParameter::name) != parameters_.end()) return;
    parameters_.push_back(parameter_from(info_of_constant(law, key), key));
  };
  for (const HeldConstant& constant : held) {
    if (!takes(kind_.row, constant.key)) {
      throw InputError(constant.where, fmt::format("'{}' is not a parameter of {}", constant.key, material.model));
    }
    if (constant.key == "poissons_ratio" && constant.value == 0.5) {
      throw InputError(constant.where, "a 'poissons_ratio' of 1/2 is written 'incompressible: true'");
    }
    parameters_.push_back(parameter_from(info_of_constant(law, constant.key), constant.key));
    parameters_.back().is_free = false;
    parameters_.back().held = constant.value;
  }
  for (const ParameterInfo& p : law.parameters) {
    const bool is_infinite = is_incompressible_ && follows_from_constants(kind_.row, p.name);
    if (is_one_of_pair(p.name) || is_infinite) continue;
    if (choosable_term_of(law, p) <= material.terms.value_or(1)) add_free(std::string(p.name));
  }
  std::vector<std::string> pair;
  for (const HeldConstant& constant : held) {
    if (is_one_of_pair(constant.key)) pair.push_back(constant.key);
  }
  const bool has_shear = has(law.parameters, "shear_modulus");
  const bool has_bulk = has(law.parameters, "bulk_modulus") || has(law.parameters, "lame_lambda");
  if (has_shear && has_bulk && !is_incompressible_) {
    for (const std::string& key : unknown_pair(pair)) add_free(key);
  } else if (has_shear) {
    add_free("shear_modulus");
  } else if (has_bulk && !is_incompressible_ && pair.empty()) {
    add_free("bulk_modulus");
  }
  // In the order of the law, the constants of the isotropic solid first.
  num_constants_ = parameters_.size();
  const auto place = [&](const FitParameter& p) {
    const auto own = std::ranges::find(law.parameters, p.name, &ParameterInfo::name);
    return is_one_of_pair(p.name) && own == law.parameters.end() ? -1 : own - law.parameters.begin();
  };
  std::ranges::stable_sort(parameters_, {}, place);
  std::vector<std::string> keys;
  for (const FitParameter& p : parameters_) keys.push_back(p.name);
  if (is_incompressible_) keys.emplace_back("bulk_modulus");
  rule_.emplace(kind_.row, keys, material.where);
}

void FitMaterial::add_branches(const FitViscosityConfig& viscosity) {
  const auto prony = std::ranges::find_if(viscosity_forms(),
                                          [](const ViscosityForm& form) { return name_of(form.blank) == Prony::name; });
  const bool holds_times = !viscosity.relaxation_times.empty();
  num_branches_ = holds_times ? viscosity.relaxation_times.size() : static_cast<std::size_t>(*viscosity.terms);
  for (std::size_t n = 0; n < num_branches_; ++n) {
    for (const ParameterInfo& info : prony->parameters) {
      parameters_.push_back(parameter_from(info, fmt::format("viscosity.{}.{}", n, info.name)));
    }
    parameters_.back().lower = 0.0;  // its logarithm is fitted
    if (!holds_times) continue;
    parameters_.back().is_free = false;
    parameters_.back().held = viscosity.relaxation_times[n];
  }
}

std::vector<double> FitMaterial::all_values(std::span<const double> free_values) const {
  std::vector<double> all;
  for (std::size_t n = 0, k = 0; n < parameters_.size(); ++n) {
    all.push_back(parameters_[n].is_free ? free_values[k++] : parameters_[n].held);
  }
  return all;
}

std::optional<std::size_t> FitMaterial::free_place(std::size_t parameter) const {
  const auto found = std::ranges::find(free_, parameter);
  if (found == free_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - free_.begin());
}

std::vector<Dual<double>> FitMaterial::dual_parameters(std::span<const double> all,
                                                       std::optional<std::size_t> seed) const {
  std::vector<Dual<double>> values(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(num_constants_));
  if (seed) values[*seed].slope = 1.0;
  if (is_incompressible_) values.emplace_back(1.0);  // of no effect
  return (*rule_)(std::span<const Dual<double>>(values));
}

ElasticLawSpec FitMaterial::law(std::span<const double> all) const {
  ElasticLawSpec spec = kind_;
  const auto parameters = dual_parameters(all, std::nullopt);
  std::ranges::transform(parameters, spec.parameters.begin(), &Dual<double>::value);
  return spec;
}

std::vector<std::pair<std::string, double>> FitMaterial::constants(std::span<const double> all) const {
  std::vector<std::pair<std::string, double>> result;
  for (std::size_t n = 0; n < num_constants_; ++n) result.emplace_back(parameters_[n].name, all[n]);
  if (is_incompressible_) result.emplace_back("poissons_ratio", 0.5);
  return result;
}

Sensitive FitMaterial::incompressible_stress(const SeededParameters& seeded, Loading loading, double amount) const {
  const Tensor3<double> H = incompressible_state(loading, amount);
  const auto free = free_entries(loading);
  Sensitive result{0.0, std::vector<double>(free_.size(), 0.0)};
  for (std::size_t k = 0; k < seeded.size(); ++k) {
    const auto P = dual_stress(kind_, seeded[k], H);
    // The pressure takes the traction from the free sides.
    const Dual<double> stress =
        free.empty() ? P(0, 1) : P(0, 0) - ((1.0 + H(free[0], free[0])) / (1.0 + H(0, 0))) * P(free[0], free[0]);
    result.value = stress.value;
    if (k < free_.size()) result.slopes[k] = stress.slope;
  }
  return result;
}

Sensitive FitMaterial::stress_at(const SeededParameters& seeded, Loading loading, const LoadedState& state) const {
  const auto free = free_entries(loading);
  const int c = loading == Loading::simple_shear ? 1 : 0;  // the entry of P that is measured
  const double stretch = 1.0 + state.H(0, 0);
  const double sign = loading == Loading::volumetric ? -1.0 / (stretch * stretch) : 1.0;
  Sensitive result{sign * nominal_stress(state, loading), std::vector<double>(free_.size(), 0.0)};
  const auto a = [&](int p, int q) { return state.A[static_cast<std::size_t>(9 * p + q)]; };
  for (std::size_t k = 0; k < seeded.size() && k < free_.size(); ++k) {
    const auto P = dual_stress(kind_, seeded[k], state.H);
    double slope = P(0, c).slope;
    if (!free.empty()) {
      // The free stretches follow the parameter: 0 = dP_f + A_ff dH_f, all of them alike.
      double stiffness = 0.0, along = 0.0;
      for (const int l : free) {
        stiffness += a(4 * free[0], 4 * l);
        along += a(c, 4 * l);
      }
      slope -= along * P(free[0], free[0]).slope / stiffness;
    }
    result.slopes[k] = sign * slope;
  }
  return result;
}

FitMaterial::SeededParameters FitMaterial::seeded(std::span<const double> all) const {
  SeededParameters result;
  for (const std::size_t n : free_) {
    if (n < num_constants_) result.push_back(dual_parameters(all, n));
  }
  if (result.empty()) result.push_back(dual_parameters(all, std::nullopt));
  return result;
}

std::vector<std::array<Sensitive, 2>> FitMaterial::stresses_of_law(std::span<const double> all, Loading loading,
                                                                   std::span<const double> amounts) const {
  const SeededParameters parameters = seeded(all);
  const int across = free_entries(loading).front();
  const Sensitive none{0.0, std::vector<double>(free_.size(), 0.0)};
  std::vector<std::array<Sensitive, 2>> result(amounts.size(), {none, none});
  for (std::size_t n = 0; n < amounts.size(); ++n) {
    const Tensor3<double> H = incompressible_state(loading, amounts[n]);
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      const auto P = dual_stress(kind_, parameters[k], H);
      for (const int side : {0, across}) {
        const Dual<double> stress = ((1.0 + H(0, 0)) / (1.0 + H(side, side))) * P(side, side);
        Sensitive& of_side = result[n][side == 0 ? 0 : 1];
        of_side.value = stress.value;
        if (k < free_.size()) of_side.slopes[k] = stress.slope;
      }
    }
  }
  return result;
}

std::vector<Sensitive> FitMaterial::stress(std::span<const double> all, Loading loading,
                                           std::span<const double> amounts) const {
  const SeededParameters parameters = seeded(all);
  std::vector<Sensitive> result(amounts.size(), {nan, std::vector<double>(free_.size(), nan)});
  if (is_incompressible_) {
    for (std::size_t n = 0; n < amounts.size(); ++n) result[n] = incompressible_stress(parameters, loading, amounts[n]);
    return result;
  }
  // From rest outwards, in tension and in compression.
  std::vector<std::size_t> order(amounts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t n) { return std::abs(amounts[n] - 1.0); });
  const ElasticLawSpec spec = law(all);
  LoadingPath tension(spec, loading), compression(spec, loading);
  for (const std::size_t n : order) {
    const auto state = (amounts[n] < 1.0 ? compression : tension).to(amounts[n]);
    if (state) result[n] = stress_at(parameters, loading, *state);
  }
  return result;
}

Sensitive FitMaterial::modulus(std::span<const double> all, Loading loading) const {
  const auto value = [&](std::optional<std::size_t> seed) -> Dual<double> {
    const auto [mu, lambda] = dual_at_rest(kind_, dual_parameters(all, seed));
    if (loading == Loading::simple_shear) return mu;
    return is_incompressible_ ? 3.0 * mu : mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu);
  };
  Sensitive result{value(std::nullopt).value, std::vector<double>(free_.size(), 0.0)};
  for (std::size_t k = 0; k < free_.size() && free_[k] < num_constants_; ++k) result.slopes[k] = value(free_[k]).slope;
  return result;
}

}  // namespace pliant
