/// Finds the cells that have given facets, edges or corners.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <algorithm>

namespace pliant {

class PartSearch {
 public:
  /// `cells`: four corner nodes each, which must outlive the search.
  explicit PartSearch(std::span<const PetscInt> cells) : cells_(cells), cells_at_(cells.size()) {
    const PetscInt last = cells.empty() ? -1 : *std::ranges::max_element(cells);
    offsets_.assign(static_cast<std::size_t>(last) + 2, 0);
    for (const PetscInt node : cells) ++offsets_[static_cast<std::size_t>(node) + 1];
    for (std::size_t i = 1; i < offsets_.size(); ++i) offsets_[i] += offsets_[i - 1];
    std::vector<std::size_t> next(offsets_.begin(), offsets_.end() - 1);
    for (std::size_t i = 0; i < cells.size(); ++i) cells_at_[next[static_cast<std::size_t>(cells[i])]++] = i / 4;
  }

  /// Calls `visit(cell, part)` for each cell that has the facet (three nodes), edge (two) or corner (one), by ascending
  /// cells; `part` as of local_part. Nodes may be negative or beyond those of the cells: no cell has them.
  template <class Visit>
  void operator()(std::span<const PetscInt> nodes, Visit visit) const {
    const auto end = static_cast<PetscInt>(offsets_.size() - 1);
    if (std::ranges::any_of(nodes, [&](PetscInt node) { return node < 0 || node >= end; })) return;
    const int dimension = static_cast<int>(nodes.size()) - 1;
    const auto first = static_cast<std::size_t>(nodes[0]);
    for (std::size_t at = offsets_[first]; at < offsets_[first + 1]; ++at) {
      const std::size_t c = cells_at_[at];
      const auto is_among = [&](int corner) {
        return std::ranges::find(nodes, cells_[4 * c + static_cast<std::size_t>(corner)]) != nodes.end();
      };
      for (std::size_t part = 0; part < num_local_parts(dimension); ++part) {
        if (std::ranges::all_of(local_part(dimension, part), is_among)) visit(c, part);
      }
    }
  }

 private:
  std::span<const PetscInt> cells_;
  std::vector<std::size_t> offsets_;   // of each node's cells
  std::vector<std::size_t> cells_at_;  // the nodes, by ascending number
};

}  // namespace pliant
