#include "fem/probe.hpp"

#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "petsc/session.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

using Point = std::array<double, 3>;

template <int Order>
struct CellMap {
  const NodeLayout& layout;
  std::span<const PetscInt> nodes;

  Point at(const Point& xi) const {
    const auto N = Tet<Order>::values(xi);
    Point x{};
    for (std::size_t a = 0; a < N.size(); ++a) {
      for (int i = 0; i < 3; ++i) x[i] += N[a] * layout.coordinates[3 * nodes[a] + i];
    }
    return x;
  }

  /// Solves x(xi) = X by Newton's method; one iteration suffices on straight cells.
  Point inverse(const Point& X) const {
    Point xi{0.25, 0.25, 0.25};
    for (int iteration = 0; iteration < 8; ++iteration) {
      const auto dN = Tet<Order>::gradients(xi);
      const Point x = at(xi);
      Tensor3<double> j{};
      for (std::size_t a = 0; a < dN.size(); ++a) {
        for (int i = 0; i < 3; ++i) {
          for (int k = 0; k < 3; ++k) j(i, k) += layout.coordinates[3 * nodes[a] + i] * dN[a][k];
        }
      }
      const Tensor3<double> inverse_transposed = (1.0 / det(j)) * cofactor(j);
      double change = 0.0;
      for (int k = 0; k < 3; ++k) {
        double d = 0.0;
        for (int i = 0; i < 3; ++i) d += inverse_transposed(i, k) * (X[i] - x[i]);
        xi[k] += d;
        change = std::max(change, std::abs(d));
      }
      if (change < 1e-14) break;
    }
    return xi;
  }
};

double distance(const Point& a, const Point& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// The smallest barycentric coordinate: how far inside the reference cell a point is; negative outside.
double depth(const Point& xi) {
  return std::min({xi[0], xi[1], xi[2], 1.0 - xi[0] - xi[1] - xi[2]});
}

template <int Order>
ProbeLocation locate_local(const NodeLayout& layout, const Point& X) {
  ProbeLocation best;
  best.distance = std::numeric_limits<double>::infinity();
  double best_depth = -1e-9;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const auto nodes = layout.nodes_of_cell(c);
    Point low = layout.position(nodes[0]), high = low;
    for (const PetscInt n : nodes) {
      const Point x = layout.position(n);
      for (int i = 0; i < 3; ++i) {
        low[i] = std::min(low[i], x[i]);
        high[i] = std::max(high[i], x[i]);
      }
    }
    bool near = true;
    for (int i = 0; i < 3; ++i) {
      const double margin = 0.1 * (high[i] - low[i]);
      near = near && X[i] >= low[i] - margin && X[i] <= high[i] + margin;
    }
    if (!near) continue;
    const CellMap<Order> map{layout, nodes};
    const Point xi = map.inverse(X);
    if (!(depth(xi) > best_depth)) continue;
    best_depth = depth(xi);
    const auto N = Tet<Order>::values(xi);
    best.nodes.assign(nodes.begin(), nodes.end());
    best.weights.assign(N.begin(), N.end());
    best.distance = 0.0;
  }
  if (best.nodes.empty()) {
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      const double d = distance(X, layout.position(n));
      if (d >= best.distance) continue;
      best.nodes = {n};
      best.weights = {1.0};
      best.distance = d;
    }
  }
  return best;
}

}  // namespace

std::array<double, 3> ProbeLocation::interpolate(std::span<const double> local) const {
  std::array<double, 3> value{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (int i = 0; i < 3; ++i) value[i] += weights[a] * local[3 * nodes[a] + i];
  }
  return value;
}

ProbeLocation locate(const NodeLayout& layout, const std::array<double, 3>& X) {
  ProbeLocation location = layout.order == 1 ? locate_local<1>(layout, X) : locate_local<2>(layout, X);
  struct {
    double distance;
    int rank;
  } mine{location.distance, rank(layout.comm)}, nearest{};
  check_mpi(MPI_Allreduce(&mine, &nearest, 1, MPI_DOUBLE_INT, MPI_MINLOC, layout.comm));
  if (nearest.rank != mine.rank) location = {};
  location.distance = nearest.distance;
  return location;
}

}  // namespace pliant
