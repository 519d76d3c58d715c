#include "fem/connected_bodies.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace pliant {
namespace {

/// Trees of nodes that hang together on this rank.
class Forest {
 public:
  explicit Forest(PetscInt size) : parent_(static_cast<std::size_t>(size)) {
    std::iota(parent_.begin(), parent_.end(), PetscInt{0});
  }
  PetscInt root(PetscInt node) {
    while (parent_[node] != node) node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void join(PetscInt a, PetscInt b) { parent_[root(a)] = root(b); }

 private:
  std::vector<PetscInt> parent_;
};

/// The least global number of a node of its piece, for each local node.
std::vector<PetscInt> pieces(const NodeLayout& layout) {
  const PetscInt n = layout.num_local_nodes;
  Forest forest(n);
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    const auto nodes = layout.nodes_of_cell(cell);
    for (const PetscInt node : nodes) forest.join(nodes.front(), node);
  }
  std::vector<PetscInt> least(static_cast<std::size_t>(n));
  for (PetscInt a = 0; a < n; ++a) least[a] = layout.global_node(a);
  // A piece that winds through many ranks takes as many rounds.
  const Handle<Vec> labels = make_vector(layout);
  bool changes = true;
  while (changes) {
    std::vector<PetscInt> of_root = least;
    for (PetscInt a = 0; a < n; ++a) of_root[forest.root(a)] = std::min(of_root[forest.root(a)], least[a]);
    {
      const GhostedView label(labels.get());
      for (PetscInt a = 0; a < n; ++a) label.span()[3 * a] = static_cast<double>(of_root[forest.root(a)]);
    }
    update_ghosts(labels.get());
    PetscInt num_changed = 0;
    const ConstGhostedView label(labels.get());
    for (PetscInt a = 0; a < n; ++a) {
      const PetscInt now = std::min(of_root[forest.root(a)], static_cast<PetscInt>(label.span()[3 * a]));
      if (now != least[a]) ++num_changed;
      least[a] = now;
    }
    changes = sum(layout.comm, static_cast<PetscInt64>(num_changed)) > 0;
  }
  return least;
}

/// The union of the ranks' numbers, ascending.
std::vector<PetscInt> on_all_ranks(MPI_Comm comm, const std::set<PetscInt>& mine) {
  const std::vector<double> sent(mine.begin(), mine.end()), received = gathered(comm, sent);
  std::vector<PetscInt> all(received.begin(), received.end());
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace

std::vector<std::vector<PetscInt>> connected_bodies(const NodeLayout& layout,
                                                    const std::function<bool(PetscInt node)>& is_held) {
  const std::vector<PetscInt> piece = pieces(layout);
  std::set<PetscInt> mine, held;
  for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
    mine.insert(piece[a]);
    if (is_held(a)) held.insert(piece[a]);
  }
  const std::vector<PetscInt> all = on_all_ranks(layout.comm, mine), all_held = on_all_ranks(layout.comm, held);
  std::map<PetscInt, std::size_t> number;
  for (const PetscInt p : all) {
    if (!std::ranges::binary_search(all_held, p)) number.emplace(p, number.size());
  }
  std::vector<std::vector<PetscInt>> bodies(number.size());
  for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
    if (const auto found = number.find(piece[a]); found != number.end()) bodies[found->second].push_back(a);
  }
  return bodies;
}

}  // namespace pliant
