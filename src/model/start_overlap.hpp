/// Surfaces of bodies that overlap at the start, where contact between them cannot begin.
#pragma once

#include "base/error.hpp"
#include "base/vector3.hpp"
#include "collision/overlaps.hpp"
#include "fem/components.hpp"
#include "input/config.hpp"

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Triangles of the surfaces that pass through other bodies or lie in them; of quadratic facets four each.
struct OverlappingFacets {
  std::vector<std::array<Vector3<double>, 3>> corners;  ///< current positions [m]
  std::vector<int> bodies, others;                      ///< to which each belongs, and with which it overlaps
  std::vector<double> depths;                           ///< of each below the other surface, as far as known [m]
};

/// The message of an overlap, with the facets, which a run writes to a file.
class OverlapError : public InputError {
 public:
  OverlapError(std::vector<Diagnostic> diagnostics, OverlappingFacets facets)
      : InputError(std::move(diagnostics)), facets_(std::move(facets)) {}
  /// The same on every rank, whatever their number.
  const OverlappingFacets& facets() const { return facets_; }

 private:
  OverlappingFacets facets_;
};

/// What overlaps, how deep and where, and what to do. `size`: of a facet, to know what is rounding [m].
std::string describe(const SurfaceOverlap& overlap, const std::vector<std::string>& body_names, double size,
                     ContactStart start, bool is_penalty);

class BodyContacts;
/// That parts of the mesh overlap although nothing keeps them apart; `between_bodies`: contact that does not, or null.
std::string describe(const Overlap& overlap, const BodyContacts* between_bodies);

}  // namespace pliant
