#include "fem/probe.hpp"

#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "fem/nearest_point.hpp"
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

/// The smallest barycentric coordinate, which measures how far inside the reference cell a point is; negative outside.
double depth(const Point& xi) {
  return std::min({xi[0], xi[1], xi[2], 1.0 - xi[0] - xi[1] - xi[2]});
}

struct Box {
  Point low, high;
};

/// A box around the owned cell, with a margin for curved sides.
Box box_of(const NodeLayout& layout, PetscInt cell) {
  const auto nodes = layout.nodes_of_cell(cell);
  Box box{layout.position(nodes[0]), layout.position(nodes[0])};
  for (const PetscInt n : nodes) {
    const Point x = layout.position(n);
    for (int i = 0; i < 3; ++i) {
      box.low[i] = std::min(box.low[i], x[i]);
      box.high[i] = std::max(box.high[i], x[i]);
    }
  }
  for (int i = 0; i < 3; ++i) {
    const double margin = 0.1 * (box.high[i] - box.low[i]);
    box.low[i] -= margin;
    box.high[i] += margin;
  }
  return box;
}

bool is_out(std::span<const char> is_left_out, PetscInt cell) {
  return !is_left_out.empty() && is_left_out[static_cast<std::size_t>(cell)] != 0;
}

/// Points in a regular grid with about as many bins.
class PointGrid {
 public:
  explicit PointGrid(std::span<const Point> points) : points_(points) {
    constexpr double inf = std::numeric_limits<double>::infinity();
    bounds_ = {{inf, inf, inf}, {-inf, -inf, -inf}};
    for (const Point& X : points) {
      for (int i = 0; i < 3; ++i) {
        bounds_.low[i] = std::min(bounds_.low[i], X[i]);
        bounds_.high[i] = std::max(bounds_.high[i], X[i]);
      }
    }
    per_side_ = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(points.size()))));
    bins_.resize(static_cast<std::size_t>(per_side_) * per_side_ * per_side_);
    for (std::size_t p = 0; p < points.size(); ++p) bins_[number(bin(points[p]))].push_back(p);
  }

  /// Calls `visit(p)` for each point p in the box.
  template <class Visit>
  void in(const Box& box, Visit visit) const {
    for (int i = 0; i < 3; ++i) {
      if (!(box.low[i] <= bounds_.high[i] && box.high[i] >= bounds_.low[i])) return;
    }
    const auto first = bin(box.low), last = bin(box.high);
    for (int i = first[0]; i <= last[0]; ++i) {
      for (int j = first[1]; j <= last[1]; ++j) {
        for (int k = first[2]; k <= last[2]; ++k) {
          for (const std::size_t p : bins_[number({i, j, k})]) {
            if (contains(box, points_[p])) visit(p);
          }
        }
      }
    }
  }

 private:
  static bool contains(const Box& box, const Point& X) {
    for (int i = 0; i < 3; ++i) {
      if (!(X[i] >= box.low[i] && X[i] <= box.high[i])) return false;
    }
    return true;
  }
  std::array<int, 3> bin(const Point& X) const {
    std::array<int, 3> index{};
    for (int i = 0; i < 3; ++i) {
      const double width = bounds_.high[i] - bounds_.low[i];
      const double part = width > 0.0 ? std::clamp((X[i] - bounds_.low[i]) / width, 0.0, 1.0) : 0.0;
      index[i] = std::min(static_cast<int>(part * per_side_), per_side_ - 1);
    }
    return index;
  }
  std::size_t number(const std::array<int, 3>& index) const {
    return (static_cast<std::size_t>(index[0]) * per_side_ + index[1]) * per_side_ + index[2];
  }

  std::span<const Point> points_;
  Box bounds_;
  int per_side_ = 1;
  std::vector<std::vector<std::size_t>> bins_;
};

constexpr double not_here = std::numeric_limits<double>::infinity();

/// A location, and by what it is chosen among those of all ranks: the lowest entries, one after another.
struct PlaceFound {
  ProbeLocation location;
  std::array<double, 4> order{not_here, not_here, not_here, not_here};
};

/// The locations in the owned cells that contain the points, of several in the one with the lowest number in the whole
/// mesh; without nodes where none does.
template <int Order>
std::vector<PlaceFound> locate_in_cells(const NodeLayout& layout, std::span<const Point> points,
                                        std::span<const char> is_left_out) {
  constexpr double rounding = 1e-9;
  std::vector<PlaceFound> found(points.size());
  for (PlaceFound& place : found) place.location.distance = not_here;
  const PointGrid grid(points);
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (is_out(is_left_out, c)) continue;
    const auto number = static_cast<double>(layout.cell_numbers[c]);
    grid.in(box_of(layout, c), [&](std::size_t p) {
      if (number > found[p].order[1]) return;
      const auto nodes = layout.nodes_of_cell(c);
      const Point xi = CellMap<Order>{layout, nodes}.inverse(points[p]);
      if (!(depth(xi) > -rounding)) return;
      const auto N = Tet<Order>::values(xi);
      found[p] = {{{nodes.begin(), nodes.end()}, {N.begin(), N.end()}, c, 0.0}, {0.0, number}};
    });
  }
  return found;
}

/// The location at the owned node nearest to X, of several at the one with the lowest coordinates.
PlaceFound locate_at_node(const NodeLayout& layout, const Point& X, std::span<const char> is_left_out) {
  PlaceFound best;
  best.location.distance = not_here;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (is_out(is_left_out, c)) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      if (n >= layout.num_owned_nodes) continue;
      const Point at = layout.position(n);
      const double d = distance(X, at);
      const std::array<double, 4> order{d, at[0], at[1], at[2]};
      if (order > best.order) continue;
      const bool is_same = order == best.order;
      if (is_same && layout.cell_numbers[c] > layout.cell_numbers[best.location.cell]) continue;
      best = {{{n}, {1.0}, c, d}, order};
    }
  }
  return best;
}

/// Keeps each location only on the rank where its order is lowest. Collective.
void keep_first(MPI_Comm comm, std::span<PlaceFound> places) {
  std::vector<char> is_first(places.size(), 1);
  std::vector<double> mine(places.size()), lowest(places.size());
  const auto reduce = [&](auto entry_of) {
    for (std::size_t p = 0; p < places.size(); ++p) mine[p] = is_first[p] != 0 ? entry_of(places[p]) : not_here;
    check_mpi(MPI_Allreduce(mine.data(), lowest.data(), static_cast<int>(mine.size()), MPI_DOUBLE, MPI_MIN, comm));
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (mine[p] > lowest[p]) is_first[p] = 0;
    }
  };
  for (std::size_t k = 0; k < 4; ++k) {
    reduce([&](const PlaceFound& place) { return place.order[k]; });
    for (std::size_t p = 0; k == 0 && p < places.size(); ++p) places[p].location.distance = lowest[p];
  }
  reduce([&](const PlaceFound&) { return static_cast<double>(rank(comm)); });
  for (std::size_t p = 0; p < places.size(); ++p) {
    if (is_first[p] == 0) places[p].location = {{}, {}, -1, places[p].location.distance};
  }
}

}  // namespace

std::array<double, 3> ProbeLocation::interpolate(std::span<const double> local) const {
  std::array<double, 3> value{};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    for (int i = 0; i < 3; ++i) value[i] += weights[a] * local[3 * nodes[a] + i];
  }
  return value;
}

std::vector<ProbeLocation> locate(const NodeLayout& layout, std::span<const std::array<double, 3>> points,
                                  std::span<const char> is_left_out) {
  std::vector<PlaceFound> found = layout.order == 1 ? locate_in_cells<1>(layout, points, is_left_out)
                                                    : locate_in_cells<2>(layout, points, is_left_out);
  keep_first(layout.comm, found);
  std::vector<PlaceFound> outside;
  for (std::size_t p = 0; p < points.size(); ++p) {
    if (found[p].location.distance == not_here) outside.push_back(locate_at_node(layout, points[p], is_left_out));
  }
  keep_first(layout.comm, outside);
  std::vector<ProbeLocation> locations;
  for (auto next = outside.begin(); PlaceFound & place : found) {
    locations.push_back(std::move((place.location.distance == not_here ? *next++ : place).location));
  }
  return locations;
}

NearestOfMesh nearest_of_mesh(const NodeLayout& layout, const std::array<double, 3>& X,
                              std::span<const char> is_left_out) {
  NearestOfMesh best{{}, std::numeric_limits<double>::infinity()};
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    if (is_out(is_left_out, c)) continue;
    const auto nodes = layout.nodes_of_cell(c);
    for (std::size_t i = 0; i < 4; ++i) {
      const Nearest nearest = nearest_point({layout.position(nodes[(i + 1) % 4]), layout.position(nodes[(i + 2) % 4]),
                                             layout.position(nodes[(i + 3) % 4])},
                                            X);
      const double d = distance(X, nearest.point);
      if (d < best.distance) best = {nearest.point, d};
    }
  }
  struct {
    double distance;
    int rank;
  } mine{best.distance, rank(layout.comm)}, all{};
  check_mpi(MPI_Allreduce(&mine, &all, 1, MPI_DOUBLE_INT, MPI_MINLOC, layout.comm));
  best.distance = all.distance;
  check_mpi(MPI_Bcast(best.point.data(), 3, MPI_DOUBLE, all.rank, layout.comm));
  return best;
}

}  // namespace pliant
