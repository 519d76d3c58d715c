#include "study/fit_starts.hpp"

#include "base/text.hpp"
#include "input/formats.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Stress over shear modulus of an incompressible neo-Hookean body.
double neo_hookean(Loading loading, double amount) {
  if (loading == Loading::uniaxial) return amount - std::pow(amount, -2);
  if (loading == Loading::equibiaxial) return amount - std::pow(amount, -5);
  if (loading == Loading::pure_shear) return amount - std::pow(amount, -3);
  return amount - 1.0;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// Moduli that the data show, roughly; none if there are no such data.
struct RoughModuli {
  std::optional<double> shear, bulk;
};

RoughModuli rough_moduli(std::span<const MaterialTest> tests) {
  std::vector<double> shear, bulk;
  const auto append = [](std::vector<double>& to, double value) {
    if (std::isfinite(value) && value > 0.0) to.push_back(value);
  };
  for (const MaterialTest& test : tests) {
    for (std::size_t n = 0; n < test.x.size(); ++n) {
      if (test.config.kind == TestKind::volumetric) {
        append(bulk, test.y[n] / (1.0 - test.x[n]));
      } else if (test.config.kind == TestKind::dma) {
        append(shear, test.y[2 * n] / (*test.config.loading == Loading::simple_shear ? 1.0 : 3.0));
      } else {
        const double amount = test.is_elastic() ? test.x[n] : test.held_amount();
        append(shear, test.y[n] / neo_hookean(*test.config.loading, amount));
      }
    }
  }
  RoughModuli moduli;
  if (!shear.empty()) moduli.shear = median(shear);
  if (!bulk.empty()) moduli.bulk = median(bulk);
  return moduli;
}

/// The shortest and the longest time in the tests of viscosity [s]; 1 if there are none.
std::vector<double> times_of(std::span<const MaterialTest> tests) {
  std::vector<double> times;
  for (const MaterialTest& test : tests) {
    for (const double x : test.x) {
      if (test.config.kind == TestKind::relaxation && x > 0.0) times.push_back(x);
      if (test.config.kind == TestKind::dma) times.push_back(1.0 / x);
    }
  }
  if (times.empty()) return {1.0, 1.0};
  return {std::ranges::min(times), std::ranges::max(times)};
}

bool is_time(const FreeParameter& p) {
  return p.fitted == FreeParameter::Fitted::logarithm;
}

}  // namespace

FitStarts::FitStarts(const FitConfig& config, const FitMaterial& material, std::span<const MaterialTest> tests)
    : earliest_latest_(times_of(tests)) {
  for (const std::size_t n : material.free()) {
    const FitParameter& p = material.parameters()[n];
    const bool is_relaxation_time = p.unit == "s";
    parameters_.push_back({p.name, p.unit, p.lower, p.upper, 1.0,
                           is_relaxation_time ? FreeParameter::Fitted::logarithm : FreeParameter::Fitted::linear});
  }
  has_bounds_.assign(parameters_.size(), false);
  guess(material, tests);
  read_bounds(config);
  read_initial(config);
  for (std::size_t j = 0; j < parameters_.size(); ++j) {
    first_[j] = std::clamp(first_[j], parameters_[j].lower, parameters_[j].upper);
    if (first_[j] != 0.0) parameters_[j].size = std::abs(first_[j]);
  }
}

void FitStarts::guess(const FitMaterial& material, std::span<const MaterialTest> tests) {
  std::vector<double> typical;
  for (const std::size_t n : material.free()) {
    const FitParameter& p = material.parameters()[n];
    typical.push_back(p.name == "bulk_modulus" ? 2e6 : p.name == "poissons_ratio" ? 0.4 : p.typical);
  }
  const RoughModuli shown = rough_moduli(tests);
  // The stiffness of the typical law, whose constants in Pa are then scaled together.
  const auto rest = material.law(material.all_values(typical)).at_rest();
  const double mu = rest && rest->mu > 0.0 ? rest->mu : 1.0;
  const double factor = shown.shear ? *shown.shear / mu : shown.bulk ? *shown.bulk / mu / 10.0 : 1.0;
  std::size_t branch = 0;
  const double count = static_cast<double>(material.num_branches());
  for (std::size_t j = 0; j < parameters_.size(); ++j) {
    const FreeParameter& p = parameters_[j];
    double value = p.unit == "Pa" ? factor * typical[j] : typical[j];
    if (p.name == "bulk_modulus" && shown.bulk) value = *shown.bulk;
    if (p.name.ends_with(".ratio")) value = 1.0 / count;
    if (is_time(p)) {
      // Spread over the decades of the data.
      const double low = std::log(earliest_latest_.front()), high = std::log(earliest_latest_.back());
      value = std::exp(low + (high - low) * (static_cast<double>(branch++) + 0.5) / count);
    }
    first_.push_back(value);
  }
}

std::size_t FitStarts::find(const NamedNode& given, const std::string& section) const {
  const auto found = std::ranges::find(parameters_, given.name, &FreeParameter::name);
  if (found != parameters_.end()) return static_cast<std::size_t>(found - parameters_.begin());
  std::vector<std::string> names;
  for (const FreeParameter& p : parameters_) names.push_back(p.name);
  throw InputError(given.node.key_where,
                   fmt::format("'{}' in '{}' is not a parameter that is fitted{}; those are {}", excerpt(given.name),
                               section, did_you_mean(given.name, names), joined(names)));
}

void FitStarts::read_bounds(const FitConfig& config) {
  Diagnostics diagnostics;
  for (const NamedNode& given : config.bounds) {
    const std::size_t j = find(given, "bounds");
    FreeParameter& p = parameters_[j];
    std::array<double, 2> pair{};
    if (!array_of<2>(quantity(p.unit)).read(given.node, given.name, diagnostics, pair)) continue;
    if (!(pair[0] < pair[1])) {
      diagnostics.add(given.node.where, fmt::format("'{}' must be [lowest, highest], the first below the second; to "
                                                    "hold a constant, give it in 'material'",
                                                    given.name));
    } else if (pair[1] < p.lower || pair[0] > p.upper) {
      diagnostics.add(given.node.where,
                      fmt::format("no value of '{}' in these bounds is admissible; it is between {:g} "
                                  "and {:g}",
                                  given.name, p.lower, p.upper));
    } else {
      p.lower = std::max(p.lower, pair[0]);
      p.upper = std::min(p.upper, pair[1]);
      has_bounds_[j] = true;
    }
  }
  diagnostics.throw_if_errors();
}

void FitStarts::read_initial(const FitConfig& config) {
  Diagnostics diagnostics;
  for (const NamedNode& given : config.initial) {
    const std::size_t j = find(given, "initial");
    const FreeParameter& p = parameters_[j];
    double value = 0.0;
    if (!quantity(p.unit).read(given.node, given.name, diagnostics, value)) continue;
    if (value < p.lower || value > p.upper || (is_time(p) && value == 0.0)) {
      diagnostics.add(given.node.where,
                      fmt::format("'{}' must be between its bounds, {:g} and {:g}", given.name, p.lower, p.upper));
    }
    first_[j] = value;
  }
  diagnostics.throw_if_errors();
}

/// A value of the parameter; `part` in (0, 1).
double FitStarts::around(std::size_t j, double part) const {
  const FreeParameter& p = parameters_[j];
  const auto between = [&](double low, double high) { return low + (high - low) * part; };
  const auto decades = [&](double low, double high) { return std::exp(between(std::log(low), std::log(high))); };
  if (has_bounds_[j]) {
    const bool is_wide = p.lower > 0.0 && p.upper > 100.0 * p.lower;
    return is_wide ? decades(p.lower, p.upper) : between(p.lower, p.upper);
  }
  constexpr double far = 10.0;
  if (is_time(p)) return decades(earliest_latest_.front() / far, earliest_latest_.back() * far);
  if (p.lower >= 0.0) return decades(first_[j] / far, first_[j] * far);
  if (p.unit == "Pa") return first_[j] + p.size * between(-2.0, 2.0);
  return first_[j] + between(-6.0, 6.0);
}

std::vector<double> FitStarts::operator()(int n) const {
  if (n == 0) return first_;
  const auto point = halton_point(n, parameters_.size());
  std::vector<double> values;
  for (std::size_t j = 0; j < parameters_.size(); ++j) {
    values.push_back(std::clamp(around(j, point[j]), parameters_[j].lower, parameters_[j].upper));
  }
  return values;
}

}  // namespace pliant
