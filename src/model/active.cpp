#include "model/active.hpp"

#include "input/directions.hpp"

namespace pliant {

template <int Order>
ActiveParts make_active_parts(const BodyConfig& config, const ActiveBody<Order>& on) {
  if (!config.active) return {};
  const ActiveConfig& active = *config.active;
  const auto& directions = active.fibre.empty() ? config.elasticity->directions : active.fibre;
  DirectionRule fibre(directions.front());
  fibre.bind(on.data);
  const FibreField field{[&](PetscInt cell, const std::array<double, 3>& X) { return fibre.at(cell, X); },
                         fibre.is_uniform() ? FibreField::Kind::parallel : FibreField::Kind::varying};
  const auto make = [&](const Expression& amount) {
    return std::make_shared<Activation>(make_activation<Order>(amount, field, on.layout, on.groups, on.body));
  };
  if (const auto* stress = std::get_if<ActiveConfig::Stress>(&active.contraction)) return {make(stress->tension), {}};
  return {{}, make(std::get<ActiveConfig::Shortening>(active.contraction).part)};
}

template ActiveParts make_active_parts<1>(const BodyConfig&, const ActiveBody<1>&);
template ActiveParts make_active_parts<2>(const BodyConfig&, const ActiveBody<2>&);

}  // namespace pliant
