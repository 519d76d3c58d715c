#include "input/elasticity.hpp"

#include "base/limits.hpp"
#include "material/loading.hpp"
#include "material/volume_split.hpp"

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

/// What `incompressible: true` stands for: a constant of the law and its value.
std::pair<std::string_view, double> incompressibility(std::size_t row) {
  if (takes(row, "poissons_ratio")) return {"poissons_ratio", 0.5};
  return {"bulk_modulus", infinity};
}

std::vector<std::string> keys_of(const ElasticityConfig& config) {
  std::vector<std::string> keys;
  for (const auto& constant : config.constants) keys.push_back(constant.key);
  if (!config.incompressible) return keys;
  for (const auto& constant : config.constants) {
    for (const auto* of_volume : {"poissons_ratio", "bulk_modulus", "lame_lambda", "lambda"}) {
      if (constant.key != of_volume) continue;
      throw InputError(constant.where, fmt::format("'{}' contradicts 'incompressible: true', which takes its place; "
                                                   "remove one of them",
                                                   constant.key));
    }
  }
  keys.emplace_back(incompressibility(row_of(config.model)).first);
  return keys;
}

}  // namespace

ElasticityRule::ElasticityRule(const ElasticityConfig& config)
    : config_(config),
      kind_{row_of(config.model), {}, config.volumetric_energy},
      rule_(kind_.row, keys_of(config), config.where) {
  std::vector<Diagnostic> errors;
  const auto wanted = kind_.info().directions;
  for (const auto& key : wanted) {
    const auto found = std::ranges::find(config.directions, key, &GivenDirection::key);
    if (found == config.directions.end()) {
      errors.push_back({Severity::error, config.where,
                        fmt::format("missing key '{}', a direction that {} needs", key, config.model)});
    } else {
      directions_.emplace_back(*found);
    }
  }
  for (const auto& d : config.directions) {
    if (std::ranges::find(wanted, d.key) != wanted.end()) continue;
    std::string names;
    for (const auto& key : wanted) names += (names.empty() ? "'" : ", '") + std::string(key) + "'";
    errors.push_back({Severity::error, d.where,
                      fmt::format("'{}' is not a direction of {}, which has {}", d.key, config.model,
                                  names.empty() ? "none" : names)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  has_uniform_constants_ = std::ranges::none_of(
      config.constants, [](const GivenConstant& c) { return c.value.depends_on_space() || !c.cell_data.empty(); });
  is_uniform_ = has_uniform_constants_ && std::ranges::all_of(directions_, &DirectionRule::is_uniform);
}

void ElasticityRule::bind(const CellData& data) {
  std::vector<Diagnostic> errors;
  const auto noting = [&](const auto& find) {
    try {
      find();
    } catch (const InputError& e) {
      errors.insert(errors.end(), e.diagnostics().begin(), e.diagnostics().end());
    }
  };
  data_ = &data;
  data_of_constant_.assign(config_.constants.size(), 0);
  for (std::size_t k = 0; k < config_.constants.size(); ++k) {
    const GivenConstant& c = config_.constants[k];
    if (!c.cell_data.empty()) noting([&] { data_of_constant_[k] = data.find(c.cell_data, 1, c.where); });
  }
  for (auto& direction : directions_) noting([&] { direction.bind(data); });
  if (!errors.empty()) throw InputError(std::move(errors));
}

std::vector<double> ElasticityRule::constants_at(PetscInt cell, const std::array<double, 3>& X) const {
  std::vector<double> values;
  for (std::size_t k = 0; k < config_.constants.size(); ++k) {
    const GivenConstant& c = config_.constants[k];
    values.push_back(c.cell_data.empty() ? c.value(X[0], X[1], X[2], 0.0) : data_->at(data_of_constant_[k], cell)[0]);
    values.back() *= c.factor;
    if (!c.cell_data.empty() && std::isnan(values.back())) {
      throw InputError(c.where, fmt::format("cell data '{}' has no value{}", c.cell_data, at_place(X)));
    }
  }
  if (config_.incompressible) values.push_back(incompressibility(kind_.row).second);
  return values;
}

void ElasticityRule::set_directions(PetscInt cell, const std::array<double, 3>& X, ElasticLawSpec& law) const {
  for (std::size_t d = 0; d < directions_.size(); ++d) {
    law.directions[d] = directions_[d].at(cell, X);
    const GivenDirection& given = directions_[d].given();
    if (given.key != "sheet") continue;
    const auto side = across(law.directions[0], law.directions[d]);
    if (!side) {
      throw InputError(given.where, "'sheet' is parallel to 'fibre'" + (is_uniform_ ? "" : at_place(X)) +
                                        "; choose a direction across it");
    }
    law.directions[d] = *side;
  }
}

std::vector<double> ElasticityRule::admissible_constants(PetscInt cell, const std::array<double, 3>& X) const {
  std::vector<double> values = constants_at(cell, X);
  std::vector<Diagnostic> errors;
  for (const auto& text : rule_.errors(values)) {
    errors.push_back({Severity::error, config_.where, has_uniform_constants_ ? text : text + "," + at_place(X)});
  }
  if (!errors.empty()) throw InputError(std::move(errors));
  return values;
}

ElasticLawSpec ElasticityRule::law_at(PetscInt cell, const std::array<double, 3>& X) const {
  ElasticLawSpec law = kind_;
  law.parameters = rule_(admissible_constants(cell, X));
  set_directions(cell, X, law);
  return law;
}

std::optional<ElasticLawSpec> ElasticityRule::up_to_rotation() const {
  if (is_uniform_) return law_at(0, {});
  const bool is_angle_fixed =
      directions_.size() == 1 || (directions_.size() == 2 && directions_[1].given().key == "sheet");
  if (!has_uniform_constants_ || !is_angle_fixed) return std::nullopt;
  ElasticLawSpec law = kind_;  // with the first axes as directions
  law.parameters = rule_(admissible_constants(0, {}));
  return law;
}

bool has_fibres(const ElasticityConfig& config) {
  const auto laws = elastic_laws();
  const auto law = std::ranges::find(laws, config.model, &LawInfo::name);
  return law != laws.end() && !law->directions.empty();
}

std::string describe(const ElasticityConfig& config) {
  const ElasticityRule rule(config);
  if (!rule.is_uniform()) {
    std::string text = config.model;
    for (const auto& c : config.constants)
      text += fmt::format("{} {} = {}", c.key == config.constants.front().key ? " with" : ",", c.key,
                          c.cell_data.empty() ? c.value.text() : "the mesh's " + c.cell_data);
    return text;
  }
  return describe(rule.law_at(0, {}));
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
  const auto split = split_volume(law);  // the tangent of an incompressible law is infinite
  const Tangent<double> A = tangent_at_rest(split ? split->rest : law);
  const double kappa = split ? split->kappa : 0.0;
  // Plane waves along the axes: the moduli of stretch and of shear there.
  WaveModuli moduli{0.0, std::numeric_limits<double>::infinity()};
  for (std::size_t p = 0; p < 9; ++p) {
    const double modulus = A[9 * p + p];
    if (p % 4 == 0) moduli.largest = std::max(moduli.largest, modulus + kappa);
    if (p % 4 != 0) moduli.smallest = std::min(moduli.smallest, modulus);
  }
  return moduli;
}

}  // namespace pliant
