/// Bodies that contract or expand.
#pragma once

#include "energy/volume/active_stress.hpp"
#include "energy/volume/expansion.hpp"
#include "input/cell_data.hpp"
#include "input/config.hpp"

#include <memory>
#include <span>

namespace pliant {

/// What the contraction or the expansion of a body is built on.
template <int Order>
struct ActiveBody {
  const CellData& data;
  const NodeLayout& layout;
  const CellGroups<Order>& groups;
  int body;
};

/// nullptr where the body has none.
struct ActiveParts {
  std::shared_ptr<const Activation> tension;  ///< [Pa]
  FreeShape shape;                            ///< the shape free of stress
};

/// Throws InputError if a stretch of `expansions`, per body of `config`, is not positive somewhere at a time.
/// Collective.
void require_positive_stretches(const Config& config, MPI_Comm comm,
                                std::span<const std::shared_ptr<const FreeExpansion>> expansions, double time);

/// Throws InputError if a contraction of `activations`, per body of `config`, is not finite somewhere at a time, or
/// fibres shorten by all of their length. Collective.
void require_possible_contractions(const Config& config, MPI_Comm comm,
                                   std::span<const std::shared_ptr<const Activation>> activations, double time);

/// Throws InputError. Not collective.
template <int Order>
ActiveParts make_active_parts(const BodyConfig& config, const ActiveBody<Order>& on);

}  // namespace pliant
