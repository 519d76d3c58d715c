#include "model/may_touch.hpp"

#include "model/rigid_bodies.hpp"
#include "model/tied_surfaces.hpp"

#include <algorithm>
#include <iterator>

namespace pliant {

std::vector<double> MayTouch::moduli(const Config& config, const std::vector<double>& shear_moduli) const {
  std::vector<double> result = shear_moduli;
  for (std::size_t b = 0; b < result.size(); ++b) result[b] = std::max(result[b], thin.shear_moduli[b]);
  give_rigid_bodies_the_largest_modulus(config, result);
  return result;
}

MayTouch find_what_may_touch(const Config& config, const NodeLayout& layout, const std::vector<int>& body_of_cell,
                             const ModelRods& rods, Selections& selections) {
  MayTouch result{find_thin_bodies(config, layout, body_of_cell, rods), {}, {}};
  auto together = tied_surfaces(config);
  std::ranges::move(attached_surfaces(config), std::back_inserter(together));
  const ContactConfig& contact = *config.contact;
  result.each_other = find_touching_surfaces(contact, together, {layout, body_of_cell, result.thin}, selections);
  result.obstacles = contact.part.kind == Selection::Kind::everything
                         ? with_segments(selections.whole_surface(), result.thin)
                         : selections.outer_facets(contact.part, contact.where, "where nothing can be touched");
  return result;
}

}  // namespace pliant
