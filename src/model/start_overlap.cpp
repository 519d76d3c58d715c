#include "model/start_overlap.hpp"

#include "model/contact_summary.hpp"

#include <fmt/format.h>

namespace pliant {

std::string describe(const SurfaceOverlap& overlap, const std::vector<std::string>& body_names, double size,
                     ContactStart start, bool is_penalty) {
  const std::string where = fmt::format("at the start in {} place{} ({} triangles)", overlap.num_places,
                                        overlap.num_places == 1 ? "" : "s", overlap.triangles.size());
  const std::string place = place_text(without_rounding(overlap.place, size));
  const std::string& body = body_names[static_cast<std::size_t>(overlap.body)];
  if (overlap.body == overlap.other) {
    return fmt::format(
        "the surface of '{}' touches or passes through itself {}, near {}; change its shape, or exclude "
        "the parts that touch ('exclude')",
        body, where, place);
  }
  const std::string pair = fmt::format("'{}' and '{}'", body, body_names[static_cast<std::size_t>(overlap.other)]);
  constexpr double deepest_resolved = 0.25;  // relative to a facet; more seldom succeeds
  const bool may_resolve =
      start == ContactStart::as_meshed && !overlap.is_thin && overlap.depth < deepest_resolved * size;
  const std::string advice = fmt::format("{}, or exclude them from contact ('exclude')",
                                         may_resolve ? "let 'start: resolve' move them apart" : "move one of them");
  if (!(overlap.depth > 0.0)) {
    return fmt::format("{} {} {}, near {}, and the barrier needs a gap between them, however small; {}", pair,
                       overlap.is_thin ? "touch or pass through each other" : "touch", where, place, advice);
  }
  return fmt::format("{} overlap {}, {:.3g} m deep at {}, which {}; {}", pair, where, overlap.depth, place,
                     is_penalty ? "is too deep for a penalty to part them" : "the barrier does not allow", advice);
}

std::string describe(const Overlap& overlap, const BodyContacts* between_bodies) {
  const std::string advice =
      between_bodies != nullptr
          ? "the surfaces that 'contact' lists do not meet there, and nothing keeps the parts from each other; move "
            "one "
            "of them in the mesh, or list whole bodies and let them be moved apart before the start ('contact: {pairs: "
            "all, start: resolve}')"
          : "no contact between them is enabled; move one of them, join them in gmsh (BooleanFragments), or let them "
            "touch, moved apart before the start ('contact: {law: barrier, pairs: all, start: resolve}')";
  return fmt::format(
      "parts of the mesh that share no node overlap at the start, {:.3g} m deep at ({:.4g}, {:.4g}, {:.4g}): {}",
      overlap.depth, overlap.at[0], overlap.at[1], overlap.at[2], advice);
}

}  // namespace pliant
