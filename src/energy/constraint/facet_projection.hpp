/// The motion of a surface, projected onto the facets of another mesh (mesh tying, mortar method).
///
/// On a facet e of the dependent surface, with shape functions phi_k, the motion u_b of the independent surface has the
/// projection
///
///   P_e u_b = sum_k phi_k p_k,   sum_l int_e phi_k phi_l dA p_l = int_e phi_k u_b dA   (least squares).
///
/// u_b at a point X of e is that of the cell behind the nearest independent facet, continued to X: sum_j N_j(X) u_j
/// with the cell's shape functions at X, even where X lies in a gap before or in an overlap behind the facet. The
/// weights of p_k therefore reproduce every linear motion, rotations with a gap included: sum_j w_kj X_j = X_k.
#pragma once

#include "base/vector3.hpp"
#include "collision/bvh.hpp"
#include "energy/constraint/polygon.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <petscsystypes.h>

namespace pliant {

/// A facet with the cell behind it, of order 1 or 2.
struct FacetOfCell {
  std::int32_t nodes_per_cell = 4;              ///< 4 or 10
  std::int32_t opposite = 0;                    ///< the corner of the cell that is not one of the facet's
  std::array<PetscInt, 10> nodes{};             ///< global nodes of the cell
  std::array<Vector3<double>, 10> positions{};  ///< of the nodes [m]
};

/// A flat triangle of a facet; `xi`: the places of its corners on the reference triangle.
struct FacetTile {
  std::array<Vector3<double>, 3> corners;
  std::array<PlanePoint, 3> xi;
};

/// The facet itself, or the four triangles between the nodes of a curved one. `nodes`: positions of 3 or 6 nodes.
std::vector<FacetTile> tiles_of(std::span<const Vector3<double>> nodes);

/// Weight of a node.
struct NodeWeight {
  PetscInt node = 0;
  double weight = 0.0;
};

class IndependentSurface {
 public:
  /// Not empty; any order of the facets gives the same surface.
  explicit IndependentSurface(std::vector<FacetOfCell> facets);

  /// The facet nearest to X, if its distance is at most `reach`. Distances along an edge that agree to rounding give
  /// the same facet whatever the partition.
  struct Place {
    std::size_t facet = 0;
    double distance = 0.0;  ///< [m]
  };
  std::optional<Place> nearest(const Vector3<double>& X, double reach) const;
  /// The distance to the nearest facet, however far it is.
  double distance(const Vector3<double>& X) const;

  const FacetOfCell& facet(std::size_t number) const { return facets_[number]; }
  /// N_j(X) of the nodes of the facet's cell, continued to any X near the facet.
  std::array<double, 10> shape_functions(std::size_t facet, const Vector3<double>& X) const;

  struct Tile {
    std::array<Vector3<double>, 3> corners;
    std::size_t facet = 0;
  };
  /// The numbers of the tiles whose boxes come as near as `reach` to the tile, ascending.
  std::vector<std::int32_t> tiles_near(const FacetTile& tile, double reach) const;
  const Tile& tile(std::int32_t number) const { return tiles_[static_cast<std::size_t>(number)]; }
  bool is_curved() const { return tiles_.size() > facets_.size(); }

 private:
  double distance(std::size_t tile, const Vector3<double>& X) const;

  std::vector<FacetOfCell> facets_;
  std::vector<Tile> tiles_;
  Bvh tree_;
  double size_ = 0.0;  // of the surface [m]
};

/// The weights of p_k, k the facet's nodes.
struct FacetProjection {
  double area = 0.0;                             ///< of the dependent facet [m^2]
  std::vector<std::vector<NodeWeight>> weights;  ///< per node of the facet, by ascending node
};

/// Projects onto the facet with these nodes (3 or 6). Integrals over it are exact where facets of both surfaces are
/// flat: it is cut along the edges of the independent facets. Points of it that are farther than `tolerance` [m] from
/// the independent surface are left out; nothing if these are more than half of it.
std::optional<FacetProjection> project(std::span<const Vector3<double>> nodes, const IndependentSurface& onto,
                                       double tolerance);

}  // namespace pliant
