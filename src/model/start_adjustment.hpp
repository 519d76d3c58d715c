/// `contact.start: resolve`: surfaces that overlap or touch at the start are moved apart in the mesh.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"
#include "model/touching_surfaces.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Moves nodes of the reference configuration, before anything is built on it, so that bodies that may touch and that
/// overlap by less than the size of a facet, touch, or are nearer than their threshold, start apart. Their surfaces
/// move, and the nodes inside them follow, so that no element is flattened; there is no strain. Bodies that are apart
/// stay as they are, as do free shells and rods.
///
/// `displacement`: at the start. `boundary`: all facets of the bodies. `as_meshed`: the layout as it is at first.
/// Returns a note for each two bodies that were moved. Throws InputError where an element would lose most of its
/// volume. Collective.
std::vector<Diagnostic> adjust_start(const ContactConfig& config, std::span<const TouchingSurfaces> touching,
                                     const std::vector<std::string>& body_names, const VectorExpression& displacement,
                                     const FacetList& boundary, const NodeLayout& as_meshed, NodeLayout& layout);

/// Whether surfaces are moved apart at the start.
bool resolves_start(const Config& config);
/// Surfaces and volumes whose nodes may coincide with those of other parts, by name or number: others are tied to them,
/// they are moved apart, or a penalty acts between them, which lets surfaces touch.
std::vector<std::string> parts_that_meet(const Config& config);

}  // namespace pliant
