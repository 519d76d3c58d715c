/// Quadrature on the reference tetrahedron (volume 1/6), triangle (area 1/2) and line (length 1).
#pragma once

#include <array>
#include <vector>

namespace pliant {

/// Points and weights on the reference simplex; the weights sum to its volume.
template <int Dim>
struct QuadratureRule {
  std::vector<std::array<double, Dim>> points;
  std::vector<double> weights;
  int size() const { return static_cast<int>(weights.size()); }
};

/// A rule exact for polynomials of the given degree: 1 point for degree <= 1, the symmetric rule of dim + 1 points for
/// degree 2 (Keast 1986, a = .58541020, b = .13819660 on the tetrahedron), on tetrahedra Walkington's 14 points up to
/// degree 5, the conical product of Gauss-Jacobi rules above; on the line Gauss's rules.
template <int Dim>
QuadratureRule<Dim> simplex_rule(int degree);

}  // namespace pliant
