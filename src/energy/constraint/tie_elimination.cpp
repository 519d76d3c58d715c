#include "energy/constraint/tie_elimination.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <unordered_map>

namespace pliant {
namespace {

/// A component of a tied node.
struct Place {
  std::size_t node = 0;  // in SurfaceTie::nodes
  PetscInt component = 0;
  auto operator<=>(const Place&) const = default;
};

/// A sum of rows u - sum of the weights' displacements = 0, each with the scale of its node.
using Rows = std::map<Place, double>;

class TieElimination {
 public:
  TieElimination(Eliminator& eliminator, const SurfaceTie& tie) : eliminator_(eliminator), tie_(tie) {
    for (std::size_t i = 0; i < tie.nodes.size(); ++i) index_[tie.nodes[i].node] = i;
  }

  void operator()() {
    std::map<Place, Rows> rows;  // of each place that keeps one
    std::vector<Place> held;
    for (std::size_t i = 0; i < tie_.nodes.size(); ++i) {
      for (PetscInt k = 0; k < 3; ++k) {
        if (is_held({i, k})) {
          held.push_back({i, k});
        } else {
          rows[{i, k}][{i, k}] += 1.0;
        }
      }
    }
    std::vector<Place> alone;  // held, and without a neighbour that takes their share
    for (const Place& place : held) {
      const auto heirs = heirs_of(place, rows);
      if (heirs.empty() && !tie_.nodes[place.node].is_shared) alone.push_back(place);
      if (!tie_.nodes[place.node].has_share) continue;
      for (const Place& heir : heirs) rows[heir][place] += 1.0 / static_cast<double>(heirs.size());
    }
    // C^T: to the unknowns of places that follow from others.
    std::map<PetscInt, Rows> of_unknown;
    for (const auto& [place, sum] : rows) {
      const PetscInt entry = entry_of(place);
      const Slave* slave = eliminator_.find(entry);
      const std::vector<ConstraintEntry> unknowns =
          slave == nullptr ? std::vector<ConstraintEntry>{{entry, 1.0}} : slave->masters;
      for (const auto& [unknown, coefficient] : unknowns) {
        for (const auto& [of, factor] : sum) of_unknown[unknown][of] += coefficient * factor;
      }
    }
    for (const auto& [unknown, sum] : of_unknown) eliminator_.add(constraint(sum), unknown);
    for (const Place& place : alone) eliminator_.add(constraint({{place, 1.0}}));
  }

 private:
  PetscInt entry_of(const Place& place) const { return 3 * tie_.nodes[place.node].node + place.component; }

  /// By something other than places of this tie.
  bool is_held(const Place& place) const {
    if (tie_.nodes[place.node].is_shared) return true;
    const Slave* slave = eliminator_.find(entry_of(place));
    if (slave == nullptr) return false;
    return slave->masters.empty() || std::ranges::any_of(slave->masters, [&](const ConstraintEntry& master) {
             return !index_.contains(master.entry / 3);
           });
  }

  /// Places with rows among the neighbours, or else among their neighbours.
  std::vector<Place> heirs_of(const Place& place, const std::map<Place, Rows>& rows) const {
    std::set<PetscInt> ring{tie_.nodes[place.node].node};
    for (int i = 0; i < 2; ++i) {
      std::set<PetscInt> next;
      for (const PetscInt node : ring) {
        const auto found = index_.find(node);
        if (found == index_.end()) continue;
        const auto& neighbours = tie_.nodes[found->second].neighbours;
        next.insert(neighbours.begin(), neighbours.end());
      }
      std::vector<Place> heirs;
      for (const PetscInt node : next) {
        const auto found = index_.find(node);
        if (found == index_.end() || !tie_.nodes[found->second].has_share) continue;
        const Place heir{found->second, place.component};
        if (rows.contains(heir)) heirs.push_back(heir);
      }
      if (!heirs.empty()) return heirs;
      ring = std::move(next);
    }
    return {};
  }

  LinearConstraint constraint(const Rows& rows) const {
    LinearConstraint result;
    result.source = tie_.source;
    double scale = 0.0;
    for (const auto& [place, factor] : rows) scale = std::max(scale, tie_.nodes[place.node].area);
    for (const auto& [place, factor] : rows) {
      const TiedNode& tied = tie_.nodes[place.node];
      const double size = factor * tied.area / scale;
      result.entries.push_back({entry_of(place), size});
      for (const auto& [node, weight] : tied.weights) {
        result.entries.push_back({3 * node + place.component, -size * weight});
      }
    }
    return result;
  }

  Eliminator& eliminator_;
  const SurfaceTie& tie_;
  std::unordered_map<PetscInt, std::size_t> index_;  // by global node
};

}  // namespace

void add_tie(Eliminator& eliminator, const SurfaceTie& tie) {
  TieElimination(eliminator, tie)();
}

}  // namespace pliant
