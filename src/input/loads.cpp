#include "input/loads.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

struct VectorOf {
  const VectorExpression* operator()(const LoadConfig::Gravity& load) const { return &load.acceleration; }
  const VectorExpression* operator()(const LoadConfig::Pressure&) const { return nullptr; }
  const VectorExpression* operator()(const LoadConfig::Foundation&) const { return nullptr; }
  const VectorExpression* operator()(const LoadConfig::PointFoundation&) const { return nullptr; }
  template <class Other>
  const VectorExpression* operator()(const Other& load) const {
    return &load.value;
  }
};

template <class Foundation>
FoundationCoefficients coefficients_of(const Foundation& foundation) {
  return {foundation.spring.value_or(0.0), foundation.dashpot.value_or(0.0)};
}

}  // namespace

const VectorExpression* vector_of(const LoadConfig& load) {
  return std::visit(VectorOf{}, load.kind);
}

std::optional<FoundationCoefficients> foundation_of(const LoadConfig& load) {
  if (const auto* surface = std::get_if<LoadConfig::Foundation>(&load.kind)) return coefficients_of(*surface);
  if (const auto* point = std::get_if<LoadConfig::PointFoundation>(&load.kind)) return coefficients_of(*point);
  return std::nullopt;
}

std::optional<LoadAtOnce> load_at_once(const Config& config) {
  const auto acts = [](const Expression& value) {
    const double now = value(0.0, 0.0, 0.0, 0.0);
    return std::isfinite(now) && now != 0.0;
  };
  const auto grown = [&](const Expression& value) {
    const bool is_number = !value.depends_on_time() && !value.depends_on_space();
    if (!acts(value)) return is_number ? value.text() : '"' + value.text() + '"';
    const std::string text = is_number ? value.text() : '(' + value.text() + ')';
    return fmt::format("\"{}*min(t/{:g}, 1)\"", text, config.time.end);
  };
  for (const LoadConfig& load : config.loads) {
    if (const VectorExpression* vector = vector_of(load)) {
      const auto& [x, y, z] = *vector;
      if (std::ranges::any_of(*vector, acts)) {
        return LoadAtOnce{load.where, fmt::format("[{}, {}, {}]", grown(x), grown(y), grown(z))};
      }
    }
    const auto* pressure = std::get_if<LoadConfig::Pressure>(&load.kind);
    if (pressure != nullptr && acts(pressure->value)) return LoadAtOnce{load.where, grown(pressure->value)};
  }
  for (const CavityConfig& cavity : config.cavities) {
    const auto* pressure = std::get_if<CavityConfig::GivenPressure>(&cavity.content);
    if (pressure != nullptr && acts(pressure->value)) return LoadAtOnce{cavity.where, grown(pressure->value)};
  }
  return std::nullopt;
}

}  // namespace pliant
