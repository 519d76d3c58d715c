#include "app/elasticity.hpp"

#include "material/registry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

std::size_t row_of(std::string_view model) {
  const auto laws = elastic_laws();
  return static_cast<std::size_t>(std::ranges::find(laws, model, &LawInfo::name) - laws.begin());
}

std::vector<std::string> keys_of(const ElasticityConfig& config) {
  std::vector<std::string> keys;
  for (const auto& constant : config.constants) keys.push_back(constant.key);
  return keys;
}

}  // namespace

ElasticityRule::ElasticityRule(const ElasticityConfig& config)
    : config_(config),
      kind_{row_of(config.model), {}, config.volumetric_energy},
      rule_(kind_.row, keys_of(config), config.where),
      is_uniform_(
          std::ranges::none_of(config.constants, [](const GivenConstant& c) { return c.value.depends_on_space(); })) {}

ElasticLawSpec ElasticityRule::law_at(const std::array<double, 3>& X) const {
  std::vector<double> values;
  for (const auto& constant : config_.constants) values.push_back(constant.value(X[0], X[1], X[2], 0.0));
  std::vector<Diagnostic> mistakes;
  for (const auto& text : rule_.complaints(values)) {
    mistakes.push_back(
        {config_.where, is_uniform_ ? text : fmt::format("{}, at ({:g}, {:g}, {:g})", text, X[0], X[1], X[2])});
  }
  if (!mistakes.empty()) throw InputError(std::move(mistakes));
  ElasticLawSpec law = kind_;
  law.parameters = rule_(values);
  return law;
}

std::string describe(const ElasticityConfig& config) {
  const ElasticityRule rule(config);
  if (!rule.is_uniform()) {
    std::string text = config.model;
    for (const auto& c : config.constants)
      text += fmt::format("{} {} = {}", c.key == config.constants.front().key ? " with" : ",", c.key, c.value.text());
    return text;
  }
  return describe(rule.law_at({0, 0, 0}));
}

std::string describe(const ElasticLawSpec& law) {
  std::string text(law.info().name);
  for (std::size_t p = 0; p < law.parameters.size(); ++p) {
    const ParameterInfo& info = law.info().parameters[p];
    text += fmt::format("{} {} = {:.4g}{}", p == 0 ? " with" : ",", info.name, law.parameters[p],
                        info.unit == "1" ? "" : " " + std::string(info.unit));
  }
  if (const auto rest = law.at_rest()) text += "; at small strain " + equivalents(*rest);
  return text;
}

WaveModuli wave_moduli(const ElasticLawSpec& law) {
  if (const auto rest = law.at_rest()) return {rest->lambda + 2.0 * rest->mu, rest->mu};
  const Tangent<double> A = std::visit([](const auto& l) { return tangent(l, Tensor3<double>{}); }, instantiate(law));
  // Plane waves along the axes: the moduli of stretch and of shear there.
  WaveModuli moduli{0.0, std::numeric_limits<double>::infinity()};
  for (std::size_t p = 0; p < 9; ++p) {
    const double modulus = A[9 * p + p];
    if (p % 4 == 0) moduli.largest = std::max(moduli.largest, modulus);
    if (p % 4 != 0) moduli.smallest = std::min(moduli.smallest, modulus);
  }
  return moduli;
}

}  // namespace pliant
