/// The curvature of a triangle of a plate from the angles at its edges and at those of its neighbours, without
/// rotations as unknowns.
///
/// The mean curvature of a triangle of area A follows from the slopes s of the deflection across its edges, at their
/// middles (basic shell triangle):
///
///     kappa = 1/A sum_e l_e (s_e - s_own,e) n_e (x) n_e,   s_own: that of the deflection that is linear in the
///     triangle
///
/// Slopes that both sides of an edge have in common make constant moments balance at every inner node of any mesh (the
/// patch test). The mean of both sides' linear slopes, s_own + theta/2 with the angle theta, is not the slope of a
/// quadratic deflection unless the mesh repeats; with the difference for the curvature kappa_e at the edge it is:
///
///     s_e - s_own,e = theta_e/2 + (d_own - d_other).kappa_e / 2
///
/// where d_own and d_other are the parts of the angle, by curvature, on both sides of the slope at the middle. kappa_e
/// is the mean over the two triangles of the curvature that fits the three angles of each. So constant curvature has
/// its exact energy and is in equilibrium, on every mesh.
///
/// Sources: Oñate & Cervera, Derivation of thin plate bending elements with one degree of freedom per node, Engineering
/// Computations 10 (1993) 543-561 (slopes as means of both sides); Flores & Oñate, A basic thin shell triangle with
/// only translational DOFs for large strain plasticity, IJNME 51 (2001) 57-83. The correction is our own.
#pragma once

#include "base/vector3.hpp"

#include <array>

namespace pliant {

/// What lies across a side of a triangle.
enum class PlateSide {
  free,      ///< nothing: no moment about the side
  folded,    ///< a neighbour
  mirrored,  ///< the image of the triangle: the side is clamped, or on a plane of symmetry
};

/// A triangle and the far corners of its neighbours: across the side from corner k to k + 1 lies `others[k]`.
struct PlateTriangle {
  std::array<Vector3<double>, 3> corners{}, others{};
  std::array<PlateSide, 3> sides{};
};

/// What the angles at the sides of a triangle say about its curvature (xx, yy, 2 xy), in its plane: the first axis is
/// along the side from corner 0 to 1. Neighbours are unfolded into it.
struct PlateFit {
  struct Side {
    PlateSide kind = PlateSide::free;
    std::array<double, 2> direction{};     ///< unit vector along it
    double length = 0.0;                   ///< [m]
    std::array<double, 3> own{}, other{};  ///< d_own and d_other [m]: the angle is (d_own + d_other).kappa
  };
  double area = 0.0;  ///< [m^2]
  std::array<Side, 3> sides;
  std::array<double, 9> curvature{};  ///< [1/m], 3 rows: that of the three angles; columns of free sides are zero
  bool is_complete = false;           ///< no side is free
};

/// Where sides are free, the curvature is that of the least energy.
PlateFit fit_plate(const PlateTriangle& triangle, double poissons_ratio);

/// The curvature of a triangle by the angles at its own sides, [k], and at those of its neighbours, [3 + 3 k + j], as
/// columns [1/m]. The common side of a neighbour is among its sides.
using PlateCurvature = std::array<std::array<double, 3>, 12>;

/// A neighbour and which of its sides is the common one; nullptr: none, or one with the opposite orientation, whose
/// curvature has no sign in common.
struct PlateNeighbour {
  const PlateFit* fit = nullptr;
  std::size_t side = 0;
};
PlateCurvature plate_curvature(const PlateFit& own, const std::array<PlateNeighbour, 3>& neighbours);

/// The matrix T, row by row, that adds to a curvature what lets the moments about free sides vanish.
std::array<double, 9> plate_extension(const PlateFit& own, double poissons_ratio);

/// The matrix C of the energy A/2 kappa.C kappa, row by row: D [1 nu 0; nu 1 0; 0 0 (1 - nu)/2], where moments about
/// free sides vanish. `rigidity`: D = E h^3 / (12 (1 - nu^2)) [N m].
std::array<double, 9> plate_stiffness(const PlateFit& own, double rigidity, double poissons_ratio);

}  // namespace pliant
