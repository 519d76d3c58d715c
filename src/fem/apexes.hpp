/// The nodes of free shells that no triangle has: the apexes of their cells, and what lies between these and the
/// corners.
#pragma once

#include "fem/layout.hpp"
#include "petsc/handle.hpp"

#include <array>
#include <span>
#include <vector>

namespace pliant {

/// The place of the apex among the corners of a free shell's cell: it has the highest number (mesh/added_shells.hpp).
std::size_t apex_of_cell(const NodeLayout& layout, PetscInt cell);
/// The apex and, with quadratic elements, the nodes in the middle of its edges. Not collective.
std::vector<PetscInt> inert_nodes_of_cell(const NodeLayout& layout, PetscInt cell);

/// An inert node that stands for no unknown, and the corners of its triangle that it follows, by weights.
struct InertNode {
  PetscInt node = 0;                  ///< local
  std::array<PetscInt, 3> corners{};  ///< local
  std::array<double, 3> weights{};
  double height = 1.0;  ///< of the apex 1
};
/// Those of the local cells with a flag, ascending, each once. Not collective.
std::vector<InertNode> inert_nodes(const NodeLayout& layout, std::span<const char> is_shell);

}  // namespace pliant
