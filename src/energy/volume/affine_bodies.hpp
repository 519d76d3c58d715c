/// The mass of bodies that move affinely, rigid ones among them: exact by the mass, its centre and its second moments.
#pragma once

#include "base/vector3.hpp"
#include "energy/volume/mass_matrix.hpp"

#include <span>
#include <vector>

namespace pliant {

/// A body all of whose nodes move affinely.
struct AffineBody {
  int body = 0;                     ///< number among the bodies of the cells
  double mass = 0.0;                ///< [kg]
  Vector3<double> centre{};         ///< of mass [m]
  Tensor3<double> second_moment{};  ///< int (X - centre) (X - centre)^T dm [kg m^2]
};

/// Adds M_ab = m N_a(c) N_b(c) + grad N_a . S grad N_b to the corners a, b of the body's largest cell, N linear.
/// Collective.
void add_affine_bodies(const NodeLayout& layout, const BlockPattern& pattern, const std::vector<int>& body_of_cell,
                       std::span<const AffineBody> bodies, MassMatrix& mass);

/// A mass that acts at a node, and the place of the body's centre [m].
struct MassAtNode {
  PetscInt node = 0;  ///< owned
  double mass = 0.0;  ///< [kg]
  Vector3<double> centre{};
};

/// What uniform accelerations act on: m N_a(c) at the corners a. Collective.
std::vector<MassAtNode> masses_of_affine_bodies(const NodeLayout& layout, const std::vector<int>& body_of_cell,
                                                std::span<const AffineBody> bodies);

}  // namespace pliant
