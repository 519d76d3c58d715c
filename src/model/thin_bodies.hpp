/// Bodies that are thinner than the mesh shows, free shells and rods, as contact sees them: what can touch, and how
/// thick it is.
#pragma once

#include "fem/layout.hpp"
#include "fem/selection.hpp"
#include "input/config.hpp"
#include "model/rods.hpp"

#include <string>
#include <utility>
#include <vector>

namespace pliant {

struct ThinBodies {
  std::vector<double> thickness;     ///< of each body of the completed input [m]; 0: it is a solid
  std::vector<char> is_rod;          ///< of each body
  std::vector<double> shear_moduli;  ///< of rods with `segments` [Pa]; 0: it is another body
  std::vector<std::string> names;    ///< of each body
  /// The segments of rods, as facets (segment_as_facet), but for those whose nodes are both nodes of a solid, in which
  /// they lie.
  FacetList segments;
  std::vector<PetscInt> cells;  ///< the local cell of each segment
  /// Rigid bodies with a surface and the rods that end in them, which do not touch them.
  std::vector<std::pair<std::string, std::vector<std::string>>> held;

  double thickness_of(int body) const { return body < 0 ? 0.0 : thickness[static_cast<std::size_t>(body)]; }
};

/// `config`: completed. A shell is as thick as it is at the start, a rod of a rectangular section as its shorter side.
/// Collective.
ThinBodies find_thin_bodies(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                            const ModelRods& rods);

/// The facets, then the segments.
FacetList with_segments(FacetList facets, const ThinBodies& thin);

}  // namespace pliant
