#include "fem/quadrature.hpp"

#include "petsc/check.hpp"

#include <cmath>

#include <petscdt.h>

namespace pliant {
namespace {

constexpr double volume(int dim) {
  return dim == 3 ? 1.0 / 6.0 : 1.0 / dim;
}

template <int Dim>
QuadratureRule<Dim> symmetric_degree_2() {
  // Tetrahedron: barycentric (a, b, b, b); triangle: (2/3, 1/6, 1/6).
  const double b = Dim == 3 ? (5.0 - std::sqrt(5.0)) / 20.0 : 1.0 / 6.0;
  const double a = 1.0 - Dim * b;
  QuadratureRule<Dim> rule;
  for (int corner = 0; corner <= Dim; ++corner) {
    std::array<double, Dim> point;
    point.fill(b);
    if (corner > 0) point[corner - 1] = a;
    rule.points.push_back(point);
    rule.weights.push_back(volume(Dim) / (Dim + 1));
  }
  return rule;
}

/// Walkington 2000, "Quadrature on simplices of arbitrary dimension": 14 points, positive weights, degree 5.
QuadratureRule<3> walkington_degree_5() {
  QuadratureRule<3> rule;
  const auto add = [&](std::array<double, 3> point, double weight) {
    rule.points.push_back(point);
    rule.weights.push_back(weight);
  };
  const double orbits[2][2] = {{0.31088591926330060980, 0.018781320953002641800},
                               {0.092735250310891226402, 0.012248840519393658257}};
  for (const auto& [b, weight] : orbits) {
    add({b, b, b}, weight);
    for (int k = 0; k < 3; ++k) {
      std::array<double, 3> point{b, b, b};
      point[k] = 1.0 - 3.0 * b;
      add(point, weight);
    }
  }
  const double c = 0.045503704125649649492, d = 0.5 - c, weight = 0.0070910034628469110730;
  for (const auto& point : {std::array{c, c, d}, {c, d, c}, {d, c, c}, {d, d, c}, {d, c, d}, {c, d, d}}) {
    add(point, weight);
  }
  return rule;
}

template <int Dim>
QuadratureRule<Dim> conical_product(int degree) {
  PetscQuadrature q = nullptr;
  const PetscInt points_per_direction = degree / 2 + 1;
  check(PetscDTStroudConicalQuadrature(Dim, 1, points_per_direction, -1.0, 1.0, &q));
  PetscInt num_points = 0;
  const PetscReal* points = nullptr;
  const PetscReal* weights = nullptr;
  check(PetscQuadratureGetData(q, nullptr, nullptr, &num_points, &points, &weights));
  QuadratureRule<Dim> rule;
  for (PetscInt i = 0; i < num_points; ++i) {
    std::array<double, Dim> point;
    for (int k = 0; k < Dim; ++k)
      point[k] = 0.5 * (points[i * Dim + k] + 1.0);  // PETSc's simplex has corners at -1 and 1
    rule.points.push_back(point);
    rule.weights.push_back(weights[i] / (1 << Dim));
  }
  check(PetscQuadratureDestroy(&q));
  return rule;
}

}  // namespace

template <int Dim>
QuadratureRule<Dim> simplex_rule(int degree) {
  if (degree <= 1) {
    std::array<double, Dim> centroid;
    centroid.fill(1.0 / (Dim + 1));
    return {{centroid}, {volume(Dim)}};
  }
  if constexpr (Dim > 1) {
    if (degree == 2) return symmetric_degree_2<Dim>();
  }
  if constexpr (Dim == 3) {
    if (degree <= 5) return walkington_degree_5();
  }
  return conical_product<Dim>(degree);
}

template QuadratureRule<1> simplex_rule<1>(int);
template QuadratureRule<2> simplex_rule<2>(int);
template QuadratureRule<3> simplex_rule<3>(int);

}  // namespace pliant
