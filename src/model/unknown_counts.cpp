#include "model/unknown_counts.hpp"

#include "fem/apexes.hpp"

#include <algorithm>

namespace pliant {

UnknownCounts count_unknowns(const Config& config, const Model& model) {
  const NodeLayout& layout = model.layout();
  std::vector<char> is_free_shell;
  for (const int body : model.body_of_cell()) {
    const auto is_it = [&](const ShellConfig& shell) {
      return shell.is_free && body >= 0 && shell.name == model.body_names()[static_cast<std::size_t>(body)];
    };
    is_free_shell.push_back(std::ranges::any_of(config.shells, is_it) ? 1 : 0);
  }
  const auto inert = std::ranges::count_if(inert_nodes(layout, is_free_shell),
                                           [&](const InertNode& node) { return node.node < layout.num_owned_nodes; });
  const auto flags = model.constraints().prescribed().flags().begin();
  const auto prescribed = std::count(flags, flags + 3 * layout.num_owned_nodes, 1);
  UnknownCounts counts;
  counts.mine = 3 * (layout.num_owned_nodes - inert);
  counts.all = sum(layout.comm, counts.mine);
  counts.prescribed = sum(layout.comm, static_cast<PetscInt64>(prescribed - 3 * inert));
  return counts;
}

}  // namespace pliant
