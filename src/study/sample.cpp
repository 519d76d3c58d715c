#include "study/sample.hpp"

#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

namespace pliant {
namespace {

constexpr int degree = 5;

/// x, y, z and weight of each point of this rank's cells.
template <int Order>
std::vector<double> quadrature_points(const NodeLayout& layout) {
  const auto rule = simplex_rule<3>(degree);
  std::vector<double> result;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    for (int p = 0; p < rule.size(); ++p) {
      const auto N = Tet<Order>::values(rule.points[p]);
      const auto dN = Tet<Order>::gradients(rule.points[p]);
      std::array<double, 3> x{};
      Tensor3<double> j{};
      for (std::size_t a = 0; a < N.size(); ++a) {
        const auto X = layout.position(nodes[a]);
        for (int i = 0; i < 3; ++i) {
          x[i] += N[a] * X[i];
          for (int k = 0; k < 3; ++k) j(i, k) += X[i] * dN[a][k];
        }
      }
      result.insert(result.end(), {x[0], x[1], x[2], rule.weights[p] * det(j)});
    }
  }
  return result;
}

/// Gathers a field at points that are spread over the ranks, on every rank.
std::vector<double> read_field(const NodeLayout& layout, const std::vector<ProbeLocation>& places, Vec x) {
  const Handle<Vec> with_ghosts = make_vector(layout);
  check(VecCopy(x, with_ghosts.get()));
  update_ghosts(with_ghosts.get());
  const ConstGhostedView local(with_ghosts.get());
  std::vector<double> values;
  for (const auto& place : places) {
    const auto value = place.interpolate(local.span());
    values.insert(values.end(), value.begin(), value.end());
  }
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM, layout.comm));
  return values;
}

}  // namespace

double nodal_mean_square(Vec x) {
  PetscReal norm = 0.0;
  PetscInt size = 0;
  check(VecNorm(x, NORM_2, &norm));
  check(VecGetSize(x, &size));
  return norm / std::sqrt(static_cast<double>(size));
}

double mean_square_distance(const Model& model, Vec a, Vec b) {
  const Handle<Vec> difference = make_vector(model.layout());
  check(VecWAXPY(difference.get(), -1.0, a, b));
  if (model.inertia() == nullptr) return nodal_mean_square(difference.get());
  update_ghosts(difference.get());
  const ConstGhostedView d(difference.get());
  const MPI_Comm comm = model.layout().comm;
  const double mass = sum(comm, model.inertia()->mass().total());
  return std::sqrt(2.0 * sum(comm, model.inertia()->kinetic_energy(d.span())) / mass);
}

Sample::Sample(const NodeLayout& layout) {
  const auto all =
      gathered(layout.comm, layout.order == 1 ? quadrature_points<1>(layout) : quadrature_points<2>(layout));
  for (std::size_t p = 0; p < all.size(); p += 4) {
    points_.push_back({all[p], all[p + 1], all[p + 2]});
    weights_.push_back(all[p + 3]);
  }
  const double volume = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  for (double& w : weights_) w /= volume;
}

SampledState Sample::read(const NodeLayout& layout, Vec q, Vec v) const {
  constexpr std::size_t most_at_once = 1 << 18;  // places take ten times the memory of what is read there
  SampledState state;
  for (std::size_t first = 0; first < points_.size(); first += most_at_once) {
    const auto places =
        locate(layout, std::span(points_).subspan(first, std::min(most_at_once, points_.size() - first)));
    for (const auto& [values, x] : {std::pair{&state.u, q}, {&state.v, v}}) {
      const auto read = read_field(layout, places, x);
      values->insert(values->end(), read.begin(), read.end());
    }
  }
  return state;
}

double Sample::distance(const std::vector<double>& a, const std::vector<double>& b) const {
  double squares = 0.0;
  for (std::size_t p = 0; p < weights_.size(); ++p) {
    for (std::size_t i = 3 * p; i < 3 * p + 3; ++i) squares += weights_[p] * std::pow(a[i] - b[i], 2);
  }
  return std::sqrt(squares);
}

}  // namespace pliant
