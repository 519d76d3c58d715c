#include "study/shape_gradient.hpp"

#include "base/tensor.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

namespace pliant {
namespace {

/// dl_a/dX of the corners of a cell [1/m].
std::array<Vector3<double>, 4> gradients_of_corners(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  std::array<Vector3<double>, 3> edges{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto from = layout.position(nodes[0]), to = layout.position(nodes[k + 1]);
    for (std::size_t i = 0; i < 3; ++i) edges[k][i] = to[i] - from[i];
  }
  std::array<Vector3<double>, 4> gradients{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3<double> normal = cross(edges[(k + 1) % 3], edges[(k + 2) % 3]);
    gradients[k + 1] = (1.0 / dot(normal, edges[k])) * normal;
    gradients[0] = gradients[0] - gradients[k + 1];
  }
  return gradients;
}

}  // namespace

std::vector<AdjointRun::Parameter> strains_of_mesh(const Config& config) {
  std::vector<AdjointRun::Parameter> parameters;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto make = [config](double) {
        Config without_probes = config;  // which would be looked for at the same places
        without_probes.probes.clear();
        without_probes.output.history.clear();
        return without_probes;
      };
      parameters.push_back({1.0, make, true, std::array{i, j}});
    }
  }
  return parameters;
}

Handle<Vec> derivatives_by_nodes(const AdjointRun& run, std::size_t first) {
  const NodeLayout& layout = run.model().layout();
  std::vector<std::vector<double>> of_cells;
  for (std::size_t n = 0; n < 9; ++n) of_cells.push_back(run.parameter(first + n).derivatives_of_cells());
  Handle<Vec> result = make_vector(layout);
  {
    const GhostedView rows(result.get());
    for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
      const auto nodes = layout.nodes_of_cell(c).first(4);
      const auto gradients = gradients_of_corners(layout, nodes);
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = 0; j < 3; ++j) {
            rows.span()[3 * static_cast<std::size_t>(nodes[a]) + i] +=
                of_cells[3 * i + j][static_cast<std::size_t>(c)] * gradients[a][j];
          }
        }
      }
    }
  }
  check(VecGhostUpdateBegin(result.get(), ADD_VALUES, SCATTER_REVERSE));
  check(VecGhostUpdateEnd(result.get(), ADD_VALUES, SCATTER_REVERSE));
  check(VecAXPY(result.get(), 1.0, run.by_position()));
  return result;
}

}  // namespace pliant
