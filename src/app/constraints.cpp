#include "app/constraints.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The support's name in the history: the surface's, else by its place in the list of constraints.
std::string support_name(const ConstraintConfig& constraint, std::size_t index) {
  return constraint.part.kind == Selection::Kind::surface ? constraint.part.name
                                                          : fmt::format("constraint{}", index + 1);
}

}  // namespace

Constraints::Constraints(const Config& config, const NodeLayout& layout, Selections& selections) {
  std::vector<PrescribedPart> parts;
  for (const auto& constraint : config.constraints) {
    parts.push_back({selections.nodes(constraint.part), constraint.displacement});
  }
  prescribed_ = std::make_unique<PrescribedDisplacement>(layout, parts, HUGE_VAL);
  on_every_rank(layout.comm, [&] {
    for (const auto& [i, j] : prescribed_->conflicts(layout, {0.0, config.time.end})) {
      selections.report(
          config.constraints[j].where,
          fmt::format("{} and {} share nodes but prescribe different displacements there; make one of them `free` or "
                      "let them agree",
                      describe(config.constraints[i].part), describe(config.constraints[j].part)));
    }
    selections.throw_mistakes();
  });
  add_supports(config, parts);
}

// Entries go under the name of the first constraint that claims them.
void Constraints::add_supports(const Config& config, const std::vector<PrescribedPart>& parts) {
  std::vector<char> claimed(prescribed_->flags().size(), 0);
  for (std::size_t c = 0; c < config.constraints.size(); ++c) {
    const std::string name = support_name(config.constraints[c], c);
    auto support = std::find_if(supports_.begin(), supports_.end(), [&](const auto& s) { return s.name == name; });
    if (support == supports_.end()) support = supports_.insert(supports_.end(), {name, {}});
    for (int i = 0; i < 3; ++i) {
      if (!config.constraints[c].displacement[i]) continue;
      for (const PetscInt node : parts[c].nodes) {
        if (std::exchange(claimed[3 * node + i], 1)) continue;
        support->dofs.push_back(3 * node + i);
      }
    }
  }
}

}  // namespace pliant
