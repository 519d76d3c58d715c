/// The term of contact between the bodies of a mesh.
#pragma once

#include "energy/contact/body_contact.hpp"
#include "energy/solid.hpp"

namespace pliant::test {

/// All outer facets of a solid, those with x < `between` of body 0, the others of body 1.
inline std::shared_ptr<const BodySurfaces> surfaces_of(const Solid& solid, double between,
                                                       FacetVertices vertices = FacetVertices::mean) {
  const FacetList facets = surface_facets(solid.mesh(), solid.layout(), [](const auto&) { return true; });
  std::vector<FacetSide> sides;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const PetscInt node = facets.nodes[static_cast<std::size_t>(f * facets.nodes_per_facet)];
    sides.push_back({solid.layout().position(node)[0] < between ? 0 : 1, 0});
  }
  return std::make_shared<const BodySurfaces>(solid.layout(), facets, sides, vertices);
}

/// Everything touches everything, with the same law.
inline std::shared_ptr<const TouchingBodies> touching(const Solid& solid, double between, const NormalLaw& law,
                                                      std::optional<FrictionUpdate> drag = std::nullopt) {
  constexpr double depth_of_penalty = 0.2;
  return std::make_shared<const TouchingBodies>(
      surfaces_of(solid, between), ContactSets{}, BodyContactLaws{2, {law, law, law, law}, {}}, drag,
      PenaltyParts{law.kind == NormalKind::penalty ? depth_of_penalty : 0.0, {}, {}});
}
inline NormalLaw barrier(double stiffness, double width, double threshold = 0.0) {
  return {NormalKind::barrier, stiffness, width, threshold};
}

}  // namespace pliant::test
