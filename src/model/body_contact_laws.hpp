/// The laws of contact of bodies with one another, as the input gives them or as they follow from material and mesh.
#pragma once

#include "energy/contact/touching_bodies.hpp"
#include "input/config.hpp"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// All bodies of the input.
struct BodyStiffnesses {
  const std::vector<std::string>& names;
  const std::vector<double>& shear_moduli;  ///< of the stiffest part of each, at rest [Pa]
};

/// The size of a facet of each body: the legs of a right triangle of the mean area [m]; 0 of bodies without any.
std::vector<double> facet_sizes(const CollisionSurface& surface, std::size_t num_bodies, double triangles_per_facet);

/// Surfaces keep the distance `thickness` of the entry or, without it, the threshold of all contact and half of the
/// thickness of free shells and rods on either side.
///
/// `pair`: the entry of `contact.pairs`; nullptr: `all`. `start`: positions of the vertices at the start [m].
/// Throws InputError where a body is thinner than the distance that its surface has to keep from itself.
BodyContactLaws body_contact_laws(const ContactConfig& config, const ContactPairConfig* pair,
                                  const BodyStiffnesses& bodies, const CollisionSurface& surface,
                                  std::span<const Vector3<double>> start, double triangles_per_facet);

/// For each two bodies whether parts of them may touch, by rows.
std::vector<char> bodies_that_may_meet(const CollisionSurface& surface, const ContactSets& sets,
                                       std::size_t num_bodies);

/// The greatest stiffness [Pa/m] and width [m] of bodies that may meet.
std::pair<double, double> stiffest_and_widest(const BodyContactLaws& laws, const std::vector<char>& may_meet);

/// The entry in words; nullptr: `all`.
std::string name_of(const ContactPairConfig* pair);

/// Throws InputError where an entry asks for a penalty, and no two bodies may meet: a body is not parted from itself.
void require_two_bodies(const ContactPairConfig* pair, const std::vector<char>& may_meet, std::size_t num_bodies);

}  // namespace pliant
