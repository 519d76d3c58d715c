/// Bodies that contract.
#pragma once

#include "energy/volume/active_stress.hpp"
#include "input/cell_data.hpp"
#include "input/config.hpp"

#include <memory>

namespace pliant {

/// What the contraction of a body is built on.
template <int Order>
struct ActiveBody {
  const CellData& data;
  const NodeLayout& layout;
  const CellGroups<Order>& groups;
  int body;
};

/// nullptr where the body has none.
struct ActiveParts {
  std::shared_ptr<const Activation> tension;     ///< [Pa]
  std::shared_ptr<const Activation> shortening;  ///< per length
};

/// Throws InputError. Not collective.
template <int Order>
ActiveParts make_active_parts(const BodyConfig& config, const ActiveBody<Order>& on);

}  // namespace pliant
