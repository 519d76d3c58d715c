#include "model/touching_surfaces.hpp"

#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include <fmt/format.h>

namespace pliant {
namespace {

using Corners = std::array<PetscInt, 3>;

Corners corners_of(std::span<const PetscInt> nodes) {
  Corners corners{nodes[0], nodes[1], nodes[2]};
  std::ranges::sort(corners);
  return corners;
}

/// Whether two entries let the same facets touch, as the one side and the other. `masks`: of all outer facets of this
/// rank. Collective.
bool repeats(MPI_Comm comm, std::span<const std::uint64_t> masks, std::span<const std::uint64_t> others) {
  std::array<bool, 4> shares{};
  for (std::size_t facet = 0; facet < masks.size(); ++facet) {
    for (std::size_t k = 0; k < 4; ++k) {
      shares[k] = shares[k] || ((masks[facet] >> (k & 1) & 1) != 0 && (others[facet] >> (k >> 1) & 1) != 0);
    }
  }
  for (bool& share : shares) share = any_rank(comm, share);
  return (shares[0] && shares[3]) || (shares[1] && shares[2]);
}

/// Bits of a facet: on the sides of the entry; of parts that do not touch each other; on the rest of a body that has
/// facets on a side, which a penalty needs to know what is inside.
constexpr int first_side = 0, second_side = 1, first_excluded = 2;
constexpr std::size_t most_excluded = 30;
constexpr int rest_of_first = 62, rest_of_second = 63;
constexpr std::uint64_t both_sides = 3, both_rests = std::uint64_t{3} << rest_of_first;

/// To which of the named parts facets belong, a bit for each.
class Membership {
 public:
  Membership(const FacetList& facets, const CellOfFacets& cells, Selections& selections)
      : facets_(facets), cells_(cells), selections_(selections), masks_(static_cast<std::size_t>(facets.size()), 0) {
    for (PetscInt facet = 0; facet < facets.size(); ++facet) number_[corners_of(facets.nodes_of(facet))] = facet;
  }

  /// Sets the bit of the facets of a surface or of the outer facets of a volume. Collective.
  void add(const Located<std::string>& name, int bit) {
    Selection surface;
    surface.kind = Selection::Kind::surface;
    surface.name = name.value;
    surface.where = name.where;
    const bool is_surface = selections_.has_group(surface.kind, name.value);
    const auto part = is_surface ? std::optional(surface) : selections_.volume_or_surface(name);
    if (part) add(*part, std::uint64_t{1} << bit);
  }
  /// Sets bits of the facets of a part of the surface, or of the outer facets of a volume. Collective.
  void add(const Selection& part, std::uint64_t mask) {
    if (part.kind == Selection::Kind::everything) {
      for (std::uint64_t& of_facet : masks_) of_facet |= mask;
      return;
    }
    if (part.kind == Selection::Kind::volume) {
      const std::vector<char> is_in = selections_.cells(part);
      for (PetscInt facet = 0; facet < facets_.size(); ++facet) {
        const auto cell = cells_(facets_.nodes_of(facet));
        if (cell && is_in[*cell] != 0) masks_[facet] |= mask;
      }
      return;
    }
    const FacetList members = selections_.outer_facets(part, part.where, "where nothing can touch it");
    for (PetscInt facet = 0; facet < members.size(); ++facet) {
      const auto found = number_.find(corners_of(members.nodes_of(facet)));
      if (found != number_.end()) masks_[found->second] |= mask;
    }
  }
  /// Sets the bit of the facets of a part of the surface, and of all that share a node with them. Collective.
  void add_around(const NodeLayout& layout, const Selection& part, int bit) {
    const std::uint64_t mask = std::uint64_t{1} << bit;
    add(part, mask);
    std::set<PetscInt> mine;
    for (PetscInt facet = 0; facet < facets_.size(); ++facet) {
      if ((masks_[facet] & mask) == 0) continue;
      for (const PetscInt n : facets_.nodes_of(facet)) mine.insert(layout.global_node(n));
    }
    const auto all = gathered(layout.comm, std::vector<PetscInt>(mine.begin(), mine.end()));
    const std::set<PetscInt> nodes(all.begin(), all.end());
    for (PetscInt facet = 0; facet < facets_.size(); ++facet) {
      const auto of_facet = facets_.nodes_of(facet);
      const bool meets =
          std::ranges::any_of(of_facet, [&](PetscInt n) { return nodes.contains(layout.global_node(n)); });
      if (meets) masks_[facet] |= mask;
    }
  }
  /// Sets a bit of the facets on neither side that belong to a body with facets on a side. Collective.
  void add_rest(MPI_Comm comm, const std::vector<int>& body_of_cell, int side, int bit) {
    int num_bodies = 0;
    for (const int body : body_of_cell) num_bodies = std::max(num_bodies, body + 1);
    std::vector<double> has_side(static_cast<std::size_t>(maximum(comm, static_cast<double>(num_bodies))), 0.0);
    const auto body_of = [&](PetscInt facet) {
      const auto cell = cells_(facets_.nodes_of(facet));
      return cell ? body_of_cell[*cell] : 0;
    };
    for (PetscInt facet = 0; facet < facets_.size(); ++facet) {
      if ((masks_[facet] >> side & 1) != 0) has_side[body_of(facet)] = 1.0;
    }
    sum_in_place(comm, has_side);
    for (PetscInt facet = 0; facet < facets_.size(); ++facet) {
      if ((masks_[facet] & both_sides) == 0 && has_side[body_of(facet)] > 0.0) masks_[facet] |= std::uint64_t{1} << bit;
    }
  }
  /// Sets bits of rods and of the rigid body in which they end. Collective.
  void add(const std::pair<std::string, std::vector<std::string>>& held, int bit) {
    const auto add_volume = [&](const std::string& name, int of_part) {
      Selection part;
      part.kind = Selection::Kind::volume;
      part.name = name;
      add(part, std::uint64_t{1} << of_part);
    };
    add_volume(held.first, bit);
    for (const std::string& rod : held.second) add_volume(rod, bit + 1);
  }
  /// Whether no facet of any rank has the bit. Collective.
  bool is_empty(MPI_Comm comm, int bit) const {
    return !any_rank(comm, std::ranges::any_of(masks_, [&](std::uint64_t mask) { return (mask >> bit & 1) != 0; }));
  }
  void copy(int from, int to) {
    for (std::uint64_t& mask : masks_) mask |= (mask >> from & 1) << to;
  }
  std::uint64_t operator[](PetscInt facet) const { return masks_[facet]; }
  const std::vector<std::uint64_t>& masks() const { return masks_; }

 private:
  const FacetList& facets_;
  const CellOfFacets& cells_;
  Selections& selections_;
  std::map<Corners, PetscInt> number_;
  std::vector<std::uint64_t> masks_;
};

/// Whether facets with the bits a are on one side and those with the bits b on the other.
bool are_on(std::uint64_t a, std::uint64_t b, int one, int other) {
  const auto has = [](std::uint64_t mask, int bit) { return (mask >> bit & 1) != 0; };
  return (has(a, one) && has(b, other)) || (has(b, one) && has(a, other));
}

bool is_excluded(std::uint64_t a, std::uint64_t b, std::size_t num_excluded) {
  for (std::size_t k = 0; k < num_excluded; ++k) {
    const int one = first_excluded + 2 * static_cast<int>(k);
    if (are_on(a, b, one, one + 1)) return true;
  }
  return false;
}

bool may_touch(std::uint64_t a, std::uint64_t b, std::size_t num_excluded) {
  if (is_excluded(a, b, num_excluded)) return false;
  return are_on(a, b, first_side, second_side) || are_on(a, b, first_side, rest_of_second) ||
         are_on(a, b, second_side, rest_of_first);
}

struct NumExcluded {
  std::size_t by_input = 0, all = 0;  ///< those of the input come first
};

/// Facets with the same bits are a set, numbered alike on all ranks. Collective.
void sort_into_sets(MPI_Comm comm, const std::vector<std::uint64_t>& masks, const NumExcluded& excluded,
                    TouchingSurfaces& touching) {
  std::vector<std::uint64_t> kinds = masks;
  std::ranges::sort(kinds);
  kinds.erase(std::ranges::unique(kinds).begin(), kinds.end());
  kinds = gathered(comm, kinds);
  std::ranges::sort(kinds);
  kinds.erase(std::ranges::unique(kinds).begin(), kinds.end());
  for (std::size_t facet = 0; facet < masks.size(); ++facet) {
    touching.sides[facet].set =
        static_cast<std::int32_t>(std::ranges::lower_bound(kinds, masks[facet]) - kinds.begin());
  }
  touching.sets = {static_cast<int>(kinds.size()), {}};
  for (const std::uint64_t a : kinds) {
    touching.set_is_on_side.push_back({(a >> first_side & 1) != 0, (a >> second_side & 1) != 0});
  }
  for (const std::uint64_t a : kinds) {
    for (const std::uint64_t b : kinds) {
      touching.sets.may_touch.push_back(may_touch(a, b, excluded.all) ? 1 : 0);
      touching.may_pass.push_back(is_excluded(a, b, excluded.by_input) ? 1 : 0);
    }
  }
}

/// Marks what never touches: parts that the input excludes, that are tied, or that hold rods. Collective.
void add_exclusions(const ContactConfig& config, const std::vector<std::array<Selection, 2>>& tied,
                    const LayoutOfBodies& bodies, Membership& membership) {
  for (std::size_t k = 0; k < config.exclude.size(); ++k) {
    for (int side = 0; side < 2; ++side) {
      membership.add(config.exclude[k][static_cast<std::size_t>(side)],
                     first_excluded + 2 * static_cast<int>(k) + side);
    }
  }
  for (std::size_t k = 0; k < tied.size(); ++k) {
    const int bit = first_excluded + 2 * static_cast<int>(config.exclude.size() + k);
    membership.add_around(bodies.layout, tied[k][0], bit);
    membership.add_around(bodies.layout, tied[k][1], bit + 1);
  }
  for (std::size_t k = 0; k < bodies.thin.held.size(); ++k) {
    const std::size_t place = config.exclude.size() + tied.size() + k;
    membership.add(bodies.thin.held[k], first_excluded + 2 * static_cast<int>(place));
  }
}

/// Reports an entry that names a rod of which nothing is outside of a solid. Collective.
void require_what_can_touch(const ContactPairConfig* pair, const Membership& membership, const LayoutOfBodies& bodies,
                            Selections& selections) {
  if (pair == nullptr) return;
  const auto require = [&](const Located<std::string>& name, int side) {
    const auto& names = bodies.thin.names;
    const auto body = std::ranges::find(names, name.value) - names.begin();
    const bool is_rod = body < std::ssize(names) && bodies.thin.is_rod[static_cast<std::size_t>(body)] != 0;
    if (!is_rod || !membership.is_empty(bodies.layout.comm, side)) return;
    selections.report(name.where, fmt::format("rod '{}' lies in another body, where nothing can touch it; name the "
                                              "surface of that body",
                                              name.value));
  };
  require(pair->part, first_side);
  if (pair->with) require(*pair->with, second_side);
}

/// Reports an entry with a penalty that shells or rods take part in. Collective.
void require_solids(const ContactConfig& config, const TouchingSurfaces& touching, const LayoutOfBodies& bodies,
                    Selections& selections) {
  int body = -1;
  for (const FacetSide& side : touching.sides) {
    if (side.thickness > 0.0) body = std::max(body, side.body);
  }
  body = static_cast<int>(maximum(bodies.layout.comm, static_cast<double>(body)));
  if (body < 0) return;
  const auto number = static_cast<std::size_t>(body);
  const ContactPairConfig* pair = touching.config;
  selections.report(
      pair != nullptr ? pair->where : config.where,
      fmt::format("{} '{}' has no inside, from which a penalty could push another body out again; use 'law: barrier'{}",
                  bodies.thin.is_rod[number] != 0 ? "rod" : "free shell", bodies.thin.names[number],
                  pair != nullptr ? "" : ", or list the pairs that touch instead of 'pairs: all'"));
}

}  // namespace

CellOfFacets::CellOfFacets(const NodeLayout& layout, const FacetList& facets, const ThinBodies& thin) {
  for (PetscInt segment = 0; segment < thin.segments.size(); ++segment) {
    cells_.insert({corners_of(thin.segments.nodes_of(segment)), thin.cells[static_cast<std::size_t>(segment)]});
  }
  std::vector<char> is_on_facets(static_cast<std::size_t>(layout.num_local_nodes), 0);
  for (const PetscInt node : facets.nodes) is_on_facets[node] = 1;
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    const auto nodes = layout.nodes_of_cell(cell);
    for (std::size_t left_out = 0; left_out < 4; ++left_out) {
      Corners corners{};
      for (std::size_t a = 0, i = 0; a < 4; ++a) {
        if (a != left_out) corners[i++] = nodes[a];
      }
      if (!std::ranges::all_of(corners, [&](PetscInt a) { return is_on_facets[a] != 0; })) continue;
      cells_.insert({corners_of(corners), cell});
    }
  }
}

std::optional<PetscInt> CellOfFacets::operator()(std::span<const PetscInt> nodes) const {
  const auto found = cells_.find(corners_of(nodes));
  return found == cells_.end() ? std::nullopt : std::optional(found->second);
}

std::vector<TouchingSurfaces> find_touching_surfaces(const ContactConfig& config,
                                                     const std::vector<std::array<Selection, 2>>& tied,
                                                     const LayoutOfBodies& bodies, Selections& selections) {
  const auto& [layout, body_of_cell, thin] = bodies;
  std::vector<TouchingSurfaces> result;
  if (config.pairs.empty()) return result;
  const std::size_t num_excluded = config.exclude.size() + tied.size() + thin.held.size();
  if (num_excluded > most_excluded) {
    selections.report(
        config.where,
        "'exclude', ties, rigid bodies in which rods end, attached and coupled surfaces are more than 30 in all; "
        "combine some in gmsh");
    return result;
  }
  const FacetList all = with_segments(selections.whole_surface(), thin);
  const CellOfFacets cells(layout, all, thin);
  std::vector<const ContactPairConfig*> entries;
  for (const ContactPairConfig& pair : config.pairs.list) entries.push_back(&pair);
  if (config.pairs.all) entries.push_back(nullptr);
  std::vector<std::vector<std::uint64_t>> sides;  // of the entries so far
  for (const ContactPairConfig* pair : entries) {
    Membership membership(all, cells, selections);
    if (pair == nullptr) {
      membership.add(config.part, both_sides);
    } else {
      membership.add(pair->part, first_side);
      if (pair->with) {
        membership.add(*pair->with, second_side);
      } else {
        membership.copy(first_side, second_side);
      }
    }
    add_exclusions(config, tied, bodies, membership);
    require_what_can_touch(pair, membership, bodies, selections);
    for (std::size_t k = 0; k < sides.size(); ++k) {
      if (!repeats(layout.comm, membership.masks(), sides[k])) continue;
      selections.report(pair->where,
                        fmt::format("contact.pairs[{}] repeats contact.pairs[{}], at least in part, and their "
                                    "pressures would add up; list each two surfaces once",
                                    sides.size(), k));
      break;
    }
    sides.push_back(membership.masks());
    if (config.law_of(pair) == NormalKind::penalty) {
      membership.add_rest(layout.comm, body_of_cell, first_side, rest_of_first);
      membership.add_rest(layout.comm, body_of_cell, second_side, rest_of_second);
    }
    TouchingSurfaces touching;
    touching.facets.nodes_per_facet = all.nodes_per_facet;
    touching.config = pair;
    touching.law = config.law_of(pair);
    std::vector<std::uint64_t> masks;
    for (PetscInt facet = 0; facet < all.size(); ++facet) {
      const auto nodes = all.nodes_of(facet);
      if ((membership[facet] & (both_sides | both_rests)) == 0) {
        touching.nodes_left_out.push_back(nodes[0]);
        continue;
      }
      const auto cell = cells(nodes);
      touching.facets.nodes.insert(touching.facets.nodes.end(), nodes.begin(), nodes.end());
      touching.facets.is_owned.push_back(all.is_owned[facet]);
      touching.facets.is_outer.push_back(1);
      const int body = cell ? body_of_cell[*cell] : 0;
      touching.sides.push_back({body, 0, thin.thickness_of(body)});
      const auto is_in = [mask = membership[facet]](auto side) { return (mask >> side & 1) != 0; };
      const bool is_of_first_alone = is_in(rest_of_first) && !is_in(second_side) && !is_in(rest_of_second);
      touching.is_on_first_side.push_back(is_in(first_side) || is_of_first_alone);
      masks.push_back(membership[facet]);
    }
    if (touching.law == NormalKind::penalty) require_solids(config, touching, bodies, selections);
    sort_into_sets(layout.comm, masks, {config.exclude.size(), num_excluded}, touching);
    result.push_back(std::move(touching));
  }
  return result;
}

void mark_planes_of_symmetry(const NodeLayout& layout, std::span<const char> prescribed, TouchingSurfaces& touching) {
  constexpr double rounding = 1e-9;
  const int num_sets = touching.sets.num_sets;
  for (PetscInt facet = 0; facet < touching.facets.size(); ++facet) {
    const auto corners = touching.facets.nodes_of(facet).first(3);
    const Vector3<double> X = layout.position(corners[0]);
    const Vector3<double> area = cross(layout.position(corners[1]) - X, layout.position(corners[2]) - X);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto is_held = [&](PetscInt node) { return prescribed[3 * node + axis] != 0; };
      const auto is_free = [&](PetscInt node) {
        return prescribed[3 * node + (axis + 1) % 3] == 0 || prescribed[3 * node + (axis + 2) % 3] == 0;
      };
      const bool is_across = std::abs(area[axis]) > (1.0 - rounding) * norm(area);
      if (is_across && std::ranges::all_of(corners, is_held) && std::ranges::any_of(corners, is_free)) {
        touching.sides[facet].set += num_sets;
      }
    }
  }
  ContactSets doubled{2 * num_sets, {}};
  for (int s = 0; s < 2 * num_sets; ++s) {
    for (int t = 0; t < 2 * num_sets; ++t) {
      doubled.may_touch.push_back(touching.sets(s % num_sets, t % num_sets) ? 1 : 0);
    }
    touching.set_is_mirror.push_back(s < num_sets ? 0 : 1);
  }
  touching.sets = std::move(doubled);
  const auto sides = touching.set_is_on_side;
  touching.set_is_on_side.insert(touching.set_is_on_side.end(), sides.begin(), sides.end());
}

void mark_rigid_parts(std::span<const int> rigid_part, TouchingSurfaces& touching) {
  for (PetscInt facet = 0; facet < touching.facets.size(); ++facet) {
    const auto nodes = touching.facets.nodes_of(facet);
    const int part = rigid_part[nodes[0]];
    const bool is_rigid = std::ranges::all_of(nodes, [&](PetscInt node) { return rigid_part[node] == part; });
    touching.sides[facet].rigid_part = is_rigid ? part : 0;
  }
}

std::vector<char> components_kept_apart(MPI_Comm comm, const Components& components,
                                        std::span<const TouchingSurfaces> touching) {
  const auto count = static_cast<std::size_t>(components.count);
  const auto component_of = [&](PetscInt node) { return static_cast<std::size_t>(components.of_node[node]); };
  std::vector<char> are_kept(count * count, 0);
  for (const TouchingSurfaces& entry : touching) {
    // The outer facets of each component that take no part, and those of each set.
    const auto num_sets = static_cast<std::size_t>(entry.sets.num_sets);
    std::vector<double> left_out(count, 0.0), of_sets(count * num_sets, 0.0), body(count, -1.0);
    for (const PetscInt node : entry.nodes_left_out) left_out[component_of(node)] += 1.0;
    for (PetscInt facet = 0; facet < entry.facets.size(); ++facet) {
      const auto set = static_cast<std::size_t>(entry.sides[facet].set);
      const std::size_t component = component_of(entry.facets.nodes_of(facet)[0]);
      of_sets[component * num_sets + set] += 1.0;
      body[component] = entry.sides[facet].body;
    }
    sum_in_place(comm, left_out);
    sum_in_place(comm, of_sets);
    for (double& number : body) number = maximum(comm, number);
    const auto are_kept_apart = [&](std::size_t a, std::size_t b) {
      bool some = false, all = left_out[a] == 0.0 && left_out[b] == 0.0;
      for (std::size_t s = 0; s < num_sets; ++s) {
        for (std::size_t t = 0; t < num_sets; ++t) {
          if (of_sets[a * num_sets + s] == 0.0 || of_sets[b * num_sets + t] == 0.0) continue;
          const bool may_touch = entry.sets(static_cast<int>(s), static_cast<int>(t));
          const bool counts = may_touch || entry.may_pass[s * num_sets + t] != 0;
          some = some || counts;
          all = all && counts;
        }
      }
      // A penalty does not part what is of one body.
      return entry.law == NormalKind::penalty ? some && body[a] != body[b] : all;
    };
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b) are_kept[a * count + b] |= a == b || are_kept_apart(a, b) ? 1 : 0;
    }
  }
  return are_kept;
}

}  // namespace pliant
