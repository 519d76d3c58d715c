/// Nodes of other ranks that no cell of this rank has.
#pragma once

#include "fem/layout.hpp"

#include <span>
#include <vector>

namespace pliant {

/// Brings the values of far nodes from the ranks that own them, after those of the layout's nodes.
class FarNodes {
 public:
  /// `globals`: those that this rank needs, ascending. `layout` outlives the object. Collective.
  FarNodes(const NodeLayout& layout, std::vector<PetscInt> globals);

  const std::vector<PetscInt>& globals() const { return globals_; }
  /// The local number of a node of the layout or a far one.
  PetscInt local_node(PetscInt global_node) const;
  /// `all` = three entries of each local node, then of each far node. `local` may be a part of `all`. Collective.
  void extend(std::span<const double> local, std::vector<double>& all) const;

 private:
  const NodeLayout& layout_;
  std::vector<PetscInt> globals_;
  Handle<PetscSF> from_owners_;
};

}  // namespace pliant
