#include "model/active.hpp"

#include "input/directions.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The largest of the amounts over all ranks; infinite if any is not finite.
double largest_of(const PerPoint<Pack>& amounts, MPI_Comm comm) {
  double largest = -HUGE_VAL;
  for (const Pack& amount : amounts.values) {
    for (int lane = 0; lane < pack_size; ++lane) {
      largest = std::isfinite(amount[lane]) ? std::max(largest, amount[lane]) : HUGE_VAL;
      if (largest == HUGE_VAL) return maximum(comm, largest);
    }
  }
  return maximum(comm, largest);
}

}  // namespace

template <int Order>
ActiveParts make_active_parts(const BodyConfig& config, const ActiveBody<Order>& on) {
  ActiveParts parts;
  if (config.expansion) {
    parts.shape.expansion = make_expansion<Order>(config.expansion->stretch, on.layout, on.groups, on.body);
  }
  if (!config.active) return parts;
  const ActiveConfig& active = *config.active;
  const auto& directions = active.fibre.empty() ? config.elasticity->directions : active.fibre;
  DirectionRule fibre(directions.front());
  fibre.bind(on.data);
  const FibreField field{[&](PetscInt cell, const std::array<double, 3>& X) { return fibre.at(cell, X); },
                         fibre.is_uniform() ? FibreField::Kind::parallel : FibreField::Kind::varying};
  const auto make = [&](const Expression& amount) {
    return std::make_shared<Activation>(make_activation<Order>(amount, field, on.layout, on.groups, on.body));
  };
  if (const auto* stress = std::get_if<ActiveConfig::Stress>(&active.contraction)) {
    parts.tension = make(stress->tension);
  } else {
    parts.shape.shortening = make(std::get<ActiveConfig::Shortening>(active.contraction).part);
  }
  return parts;
}

void require_positive_stretches(const Config& config, MPI_Comm comm,
                                std::span<const std::shared_ptr<const FreeExpansion>> expansions, double time) {
  for (std::size_t b = 0; b < expansions.size(); ++b) {
    if (!expansions[b]) continue;
    double smallest = HUGE_VAL;
    for (const Pack& change : expansions[b]->changes({.time = time}).values) {
      for (int lane = 0; lane < pack_size; ++lane) {
        const double s = 1.0 + change[lane];
        smallest = std::isfinite(s) ? std::min(smallest, s) : -HUGE_VAL;
      }
    }
    smallest = minimum(comm, smallest);
    if (smallest > 0.0) continue;
    const Location& where = config.bodies[b].expansion->where;
    if (std::isinf(smallest)) throw InputError(where, fmt::format("the stretch is not finite at t = {:g}", time));
    throw InputError(where,
                     fmt::format("the stretch must be > 0 in the whole body; at t = {:g} it is {:.4g}. 1 means no "
                                 "expansion, 1.02 makes free lengths 2 % longer",
                                 time, smallest));
  }
}

void require_possible_contractions(const Config& config, MPI_Comm comm,
                                   std::span<const std::shared_ptr<const Activation>> activations, double time) {
  for (std::size_t b = 0; b < activations.size(); ++b) {
    if (!activations[b]) continue;
    const double largest = largest_of(activations[b]->amounts({.time = time}), comm);
    const ActiveConfig& active = *config.bodies[b].active;
    const bool shortens = std::holds_alternative<ActiveConfig::Shortening>(active.contraction);
    if (largest == HUGE_VAL) {
      throw InputError(active.where, fmt::format("the {} is not finite at t = {:g}",
                                                 shortens ? "shortening" : "active stress", time));
    }
    if (!shortens || largest < 1.0) continue;
    throw InputError(
        active.where,
        fmt::format("the shortening must be below 1 in the whole body; at t = {:g} it is {:.4g}. 0.2 makes "
                    "fibres 20 % shorter",
                    time, largest));
  }
}

template ActiveParts make_active_parts<1>(const BodyConfig&, const ActiveBody<1>&);
template ActiveParts make_active_parts<2>(const BodyConfig&, const ActiveBody<2>&);

}  // namespace pliant
