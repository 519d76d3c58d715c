#include "command/material_plot.hpp"

#include "base/text.hpp"
#include "base/units.hpp"
#include "material/constants.hpp"
#include "material/library.hpp"
#include "material/loading.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The parameter or elastic constant of that name; nullptr if the law has none.
const ParameterInfo* find_parameter(const LawInfo& law, std::string_view name) {
  for (const auto& parameters : {law.parameters, elastic_constants()}) {
    const auto found = std::ranges::find(parameters, name, &ParameterInfo::name);
    if (found != parameters.end()) return &*found;
  }
  return nullptr;
}

std::pair<std::string, double> parsed(const LawInfo& law, const std::string& setting) {
  const std::size_t sign = setting.find('=');
  const std::string key = setting.substr(0, sign);
  const ParameterInfo* parameter = find_parameter(law, key);
  if (sign == std::string::npos || parameter == nullptr) {
    std::vector<std::string> names;
    for (const auto& p : law.parameters) names.emplace_back(p.name);
    throw InputError({}, fmt::format("--set {}: not a parameter of {}{}; write one of {} as KEY=VALUE", setting,
                                     law.name, did_you_mean(key, names), joined(names)));
  }
  try {
    return {key, parse_quantity(setting.substr(sign + 1), std::string(parameter->unit))};
  } catch (const UnitError& error) {
    throw InputError({}, fmt::format("--set {}: {}", setting, error.what()));
  }
}

}  // namespace

ElasticLawSpec law_for_plot(const std::string& name, const std::vector<std::string>& settings) {
  const auto rows = elastic_laws();
  const LibraryMaterial* material = find_material(name);
  const auto row = std::ranges::find(rows, material != nullptr ? material->law : name, &LawInfo::name);
  if (row == rows.end()) {
    std::vector<std::string> names;
    for (const auto& law : rows) names.emplace_back(law.name);
    for (const auto& entry : material_library()) names.emplace_back(entry.name);
    throw InputError({}, fmt::format("unknown elastic law or material '{}'{}; choose one of {}", name,
                                     did_you_mean(name, names), joined(names)));
  }
  GivenConstants constants;
  for (const auto& setting : settings) constants.insert(parsed(*row, setting));
  if (material != nullptr) {
    const bool gives_volume = constants.contains("poissons_ratio") || constants.contains("bulk_modulus");
    for (const auto& [key, value] : constants_of(*material)) {
      if (key != "poissons_ratio" || !gives_volume) constants.emplace(key, value);
    }
    return make_law(material->law, constants);
  }
  // Elastic constants that the law does not have replace those that it has.
  const bool replaces = std::ranges::any_of(constants, [&](const auto& given) {
    return std::ranges::find(row->parameters, given.first, &ParameterInfo::name) == row->parameters.end();
  });
  for (const auto& p : row->parameters) {
    const bool is_replaced = replaces && follows_from_constants(static_cast<std::size_t>(row - rows.begin()), p.name);
    if (!is_replaced) constants.emplace(p.name, p.typical);
  }
  return make_law(name, constants);
}

Plot stress_stretch_plot(const ElasticLawSpec& law, double lowest, double highest) {
  constexpr int num_points = 160;
  Plot plot{fmt::format("{}: nominal stress in tension, biaxial tension and shear", law.info().name),
            "stretch; 1 + amount of shear",
            "force per reference area [kPa]",
            {}};
  plot.scale = Scale::linear;
  for (const Loading loading : {Loading::uniaxial, Loading::equibiaxial, Loading::simple_shear}) {
    const LoadingInfo& info = loadings[static_cast<std::size_t>(loading)];
    PlotSeries series{fmt::format("{}, {}", info.name, info.stress), {}, {}};
    const double from = loading == Loading::simple_shear ? std::max(lowest, 1.0) : lowest;
    for (int k = 0; k <= num_points; ++k) {
      const double amount = from + (highest - from) * k / num_points;
      if (const auto state = loaded(law, loading, amount)) {
        series.x.push_back(amount);
        series.y.push_back(1e-3 * nominal_stress(*state, loading));
      }
    }
    plot.series.push_back(std::move(series));
  }
  return plot;
}

}  // namespace pliant
