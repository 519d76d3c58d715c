/// Moves the surfaces of bodies that overlap or touch apart, before they are used: a change of the mesh, without
/// strain.
#pragma once

#include "collision/contact_pairs.hpp"
#include "energy/contact/body_surfaces.hpp"

#include <span>
#include <vector>

namespace pliant {

/// How far apart two bodies are to be.
struct GapGoal {
  double wanted = 0.0;   ///< to which they are moved [m]; 0: they are left as they are
  double least = 0.0;    ///< which will do, where the meshes do not fit [m]
  double deepest = 0.0;  ///< the greatest depth that is cured [m]
  double depth = 0.0;    ///< of their overlap, as far as known [m]
};

/// Those of each two bodies (FacetSide::body): a symmetric matrix by rows.
struct GapGoals {
  int num_bodies = 1;
  std::vector<GapGoal> of_bodies;

  const GapGoal& of(int body, int other) const { return of_bodies[num_bodies * body + other]; }
};

/// Moves the nodes `x` [m], as of the vertices of the surfaces. All surfaces have the same facets and differ in where
/// the vertices of quadratic ones are.
///
/// First each node that is too close to another body goes half of the way along the normal there, so that flat surfaces
/// that touch stay flat; then, where that is too little, corners, middles of edges and centres of triangles, and
/// edges that pass through triangles, are moved away from what they meet one after another, by the least motion of all
/// nodes concerned (projection as in position-based dynamics, Mueller et al. 2007). Results depend on the partition by
/// rounding only. What is too deep, or does not come apart, is left: look for overlaps afterwards. Rank-local.
void move_apart(std::span<const BodySurfaces* const> surfaces, const ContactSets& sets, const GapGoals& goals,
                std::span<Vector3<double>> x);

}  // namespace pliant
