#include "model/selections.hpp"

#include "base/text.hpp"
#include "fem/apexes.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace pliant {
namespace {

int dimension(Selection::Kind kind) {
  switch (kind) {
    case Selection::Kind::volume:
      return 3;
    case Selection::Kind::surface:
      return 2;
    case Selection::Kind::curve:
      return 1;
    default:
      return 0;
  }
}

const char* noun(int dimension) {
  constexpr const char* nouns[] = {"point", "curve", "surface", "volume"};
  return nouns[dimension];
}

bool is_group(Selection::Kind kind) {
  using Kind = Selection::Kind;
  return kind == Kind::volume || kind == Kind::surface || kind == Kind::curve || kind == Kind::point;
}

std::string title(const PhysicalGroup& group) {
  return group.name.empty() ? std::to_string(group.tag) : group.name;
}

/// The condition of a box or a region.
Region region(const Selection& part) {
  if (part.kind == Selection::Kind::box) {
    return [box = part.box](const std::array<double, 3>& x) {
      for (int i = 0; i < 3; ++i) {
        if (x[i] < box[i] || x[i] > box[i + 3]) return false;
      }
      return true;
    };
  }
  return [&inside = *part.region](const std::array<double, 3>& x) { return inside(x[0], x[1], x[2], 0.0) != 0.0; };
}

/// What is reported of a group of the mesh that is empty.
std::string holds_nothing(const Selection& part) {
  return fmt::format(
      "{} is defined in the mesh, but holds nothing of it; in a .geo, a BoundingBox has its lower "
      "corner first and must be a little larger than what it is to contain (widen it by 1e-6 or so on "
      "every side), and Boolean operations change the numbers of entities",
      describe(part));
}

}  // namespace

std::string describe(const Selection& part) {
  switch (part.kind) {
    case Selection::Kind::everything:
      return "the whole mesh";
    case Selection::Kind::box:
      return "the box";
    case Selection::Kind::where:
      return fmt::format("where \"{}\"", part.region->text());
    default:
      return fmt::format("{} '{}'", noun(dimension(part.kind)), part.name);
  }
}

Selections::Selections(const Mesh& mesh, const NodeLayout& layout, AddedBodies added)
    : mesh_(mesh), layout_(layout), added_(std::move(added)) {
  std::vector<PhysicalGroup> groups;
  for (const PhysicalGroup& g : mesh.groups) {
    if (is_added(g)) groups.push_back(g);
  }
  if (groups.empty()) return;
  added_node_.assign(static_cast<std::size_t>(layout.num_local_nodes), Added::none);
  const auto of_cells = volume_of_cells(mesh, layout, groups);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    const int group = of_cells[static_cast<std::size_t>(c)];
    if (group < 0) continue;
    const std::string& name = groups[static_cast<std::size_t>(group)].name;
    if (std::ranges::find(added_.shells, name) != added_.shells.end()) {
      for (const PetscInt n : inert_nodes_of_cell(layout, c)) added_node_[static_cast<std::size_t>(n)] = Added::inert;
      continue;
    }
    const bool stands = std::ranges::find(added_.without_surface, name) != added_.without_surface.end();
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      added_node_[static_cast<std::size_t>(n)] = stands ? Added::without_surface : Added::with_surface;
    }
  }
  // Nodes of a rod along a curve of the mesh are the mesh's.
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (of_cells[static_cast<std::size_t>(c)] >= 0) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) added_node_[static_cast<std::size_t>(n)] = Added::none;
  }
}

std::vector<PetscInt> Selections::inert_nodes() const {
  std::vector<PetscInt> result;
  for (PetscInt n = 0; n < layout_.num_owned_nodes && !added_node_.empty(); ++n) {
    if (added_node_[static_cast<std::size_t>(n)] == Added::inert) result.push_back(n);
  }
  return result;
}

bool Selections::is_added(const PhysicalGroup& group) const {
  return group.dimension == 3 && std::ranges::find(added_.names, group.name) != added_.names.end();
}

const PhysicalGroup* Selections::curve_of(const PhysicalGroup& group) const {
  if (group.dimension != 3) return nullptr;
  const auto rod = std::ranges::find(added_.on_curves, group.name, &std::pair<std::string, std::string>::first);
  if (rod == added_.on_curves.end()) return nullptr;
  const auto is_it = [&](const PhysicalGroup& other) { return other.dimension == 1 && other.name == rod->second; };
  const auto found = std::ranges::find_if(mesh_.groups, is_it);
  return found == mesh_.groups.end() ? nullptr : &*found;
}

FacetList Selections::without(const FacetList& facets, std::initializer_list<Added> kinds) const {
  if (added_node_.empty()) return facets;
  FacetList result;
  result.nodes_per_facet = facets.nodes_per_facet;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = facets.nodes_of(f);
    const auto is_of_kinds = [&](PetscInt n) {
      return std::ranges::find(kinds, added_node_[static_cast<std::size_t>(n)]) != kinds.end();
    };
    if (std::ranges::any_of(nodes, is_of_kinds)) continue;
    result.nodes.insert(result.nodes.end(), nodes.begin(), nodes.end());
    result.is_owned.push_back(facets.is_owned[static_cast<std::size_t>(f)]);
    result.is_outer.push_back(facets.is_outer[static_cast<std::size_t>(f)]);
  }
  return result;
}

const PhysicalGroup* Selections::find_group(int dimension, const std::string& name) const {
  const auto find = [&](auto is_it) -> const PhysicalGroup* {
    const auto found = std::ranges::find_if(
        mesh_.groups, [&](const PhysicalGroup& group) { return group.dimension == dimension && is_it(group); });
    return found != mesh_.groups.end() ? &*found : nullptr;
  };
  if (const auto* named = find([&](const PhysicalGroup& group) { return group.name == name; })) return named;
  return find([&](const PhysicalGroup& group) { return std::to_string(group.tag) == name; });
}

const PhysicalGroup* Selections::group(const Selection& part) {
  const int d = dimension(part.kind);
  if (const PhysicalGroup* found = find_group(d, part.name)) {
    used_.push_back(found);
    return found;
  }
  std::vector<std::string> names;
  for (const auto& g : mesh_.groups) {
    if (g.dimension == d) names.push_back(title(g));
  }
  const std::string hint = did_you_mean(part.name, names);
  std::string known = names.empty() ? fmt::format("the mesh has no physical {}s", noun(d))
                                    : fmt::format("the mesh has: {}", joined(names));
  for (const auto& g : mesh_.groups) {
    if (g.dimension != d && title(g) == part.name) {
      known = fmt::format("'{0}' is a {1} of the mesh (`{1}: {0}`)", part.name, noun(g.dimension));
    }
  }
  report(part.where, fmt::format("no {} '{}' in the mesh{}; {}", noun(d), part.name, hint, known));
  return nullptr;
}

std::vector<PetscInt> Selections::nodes(const Selection& part) {
  std::vector<PetscInt> result;
  if (is_group(part.kind)) {
    const PhysicalGroup* g = group(part);
    if (g == nullptr) return result;
    result = nodes_of_group(mesh_, layout_, *g);
    const PhysicalGroup* curve = curve_of(*g);
    if (curve != nullptr && sum(layout_.comm, static_cast<PetscInt64>(result.size())) == 0) {
      result = nodes_of_group(mesh_, layout_, *curve);
    }
  } else if (part.kind == Selection::Kind::everything) {
    result = nodes_in_region(layout_, [](const auto&) { return true; });
  } else {
    result = nodes_in_region(layout_, region(part));
  }
  if (!added_node_.empty()) {
    std::erase_if(result, [&](PetscInt n) {
      const Added added = added_node_[static_cast<std::size_t>(n)];
      return added == Added::inert || (added != Added::none && !is_group(part.kind));
    });
  }
  if (sum(layout_.comm, static_cast<PetscInt64>(result.size())) == 0) {
    report(part.where, is_group(part.kind) ? holds_nothing(part)
                                           : fmt::format("{} contains no node of the mesh; `pliant check` shows the "
                                                         "mesh's extent and groups",
                                                         describe(part)));
  }
  return result;
}

FacetList Selections::facets(const Selection& part) {
  FacetList result;
  if (part.kind == Selection::Kind::surface) {
    const PhysicalGroup* g = group(part);
    if (g == nullptr) return result;
    result = facets_of_group(mesh_, layout_, *g);
  } else if (part.kind == Selection::Kind::everything) {
    result = whole_surface();
  } else {
    result = without(surface_facets(mesh_, layout_, region(part)),
                     {Added::with_surface, Added::without_surface, Added::inert});
  }
  if (sum(layout_.comm, static_cast<PetscInt64>(result.size())) == 0) {
    report(part.where, is_group(part.kind) ? holds_nothing(part)
                                           : fmt::format("{} contains no facet of the mesh's surface; `pliant check` "
                                                         "shows the mesh's extent and groups",
                                                         describe(part)));
  }
  return result;
}

FacetList Selections::whole_surface() const {
  return without(surface_facets(mesh_, layout_, [](const auto&) { return true; }),
                 {Added::without_surface, Added::inert});
}

FacetList Selections::outer_facets(const Selection& part, const Location& where, const std::string& reason) {
  FacetList result = facets(part);
  if (any_rank(layout_.comm, std::ranges::find(result.is_outer, 0) != result.is_outer.end())) {
    report(where, fmt::format("{} lies inside the mesh, {}; name a part of the outer surface", describe(part), reason));
  }
  return result;
}

bool Selections::has_group(Selection::Kind kind, const std::string& name) const {
  return find_group(dimension(kind), name) != nullptr;
}

std::optional<Selection> Selections::volume_or_surface(const Located<std::string>& name) {
  Selection part;
  part.name = name.value;
  part.where = name.where;
  for (const auto kind : {Selection::Kind::volume, Selection::Kind::surface}) {
    part.kind = kind;
    if (has_group(kind, name.value)) return part;
  }
  std::vector<std::string> names;
  for (const int d : {3, 2}) {
    for (const auto& g : mesh_.groups) {
      if (g.dimension == d) names.push_back(title(g));
    }
  }
  report(name.where,
         fmt::format("no volume, surface or rigid body '{}'{}; {}", name.value, did_you_mean(name.value, names),
                     names.empty() ? "the mesh has none: leave the key out for all bodies"
                                   : fmt::format("there are: {}", joined(names))));
  return std::nullopt;
}

EdgeList Selections::edges(const Selection& part) {
  const PhysicalGroup* g = group(part);
  if (g == nullptr) return {};
  EdgeList result = edges_of_group(mesh_, layout_, *g);
  if (sum(layout_.comm, static_cast<PetscInt64>(result.size())) == 0) {
    report(part.where,
           fmt::format("{} contains no edge of a tetrahedron; it must bound a volume or be embedded in one (in "
                       "gmsh: Curve {{1}} In Volume {{1}})",
                       describe(part)));
  }
  return result;
}

std::vector<int> Selections::cells(const std::vector<Selection>& parts) {
  std::vector<int> result(layout_.num_local_cells, parts.empty() ? -1 : 0);
  const bool whole = parts.size() == 1 && parts[0].kind == Selection::Kind::everything;
  if (whole) {
    for (const auto& g : mesh_.groups) {
      if (g.dimension == 3) used_.push_back(&g);
    }
    return result;
  }
  std::vector<PhysicalGroup> groups;
  std::vector<int> part_of_group;
  int rest = -1;  // what has all the others
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (parts[p].kind == Selection::Kind::everything) {
      rest = static_cast<int>(p);
      continue;
    }
    const PhysicalGroup* g = group(parts[p]);
    if (g == nullptr) continue;
    if (!is_added(*g) && mesh_.report.groups[static_cast<std::size_t>(g - mesh_.groups.data())].count == 0) {
      report(parts[p].where, holds_nothing(parts[p]));
      continue;
    }
    groups.push_back(*g);
    part_of_group.push_back(static_cast<int>(p));
  }
  if (groups.size() + (rest < 0 ? 0 : 1) != parts.size()) return result;
  result = volume_of_cells(mesh_, layout_, groups);
  if (rest >= 0) {
    for (int& part : result) part = part < 0 ? rest : part_of_group[static_cast<std::size_t>(part)];
    return result;
  }
  PetscInt64 without = 0, several = 0;
  for (PetscInt c = 0; c < layout_.num_owned_cells; ++c) {
    without += result[c] == -1;
    several += result[c] == -2;
  }
  without = sum(layout_.comm, without);
  several = sum(layout_.comm, several);
  if (without > 0) {
    std::vector<std::string> missing;
    for (const auto& g : mesh_.groups) {
      const bool used = std::any_of(groups.begin(), groups.end(), [&](const auto& u) { return u.tag == g.tag; });
      if (g.dimension == 3 && !used) missing.push_back(title(g));
    }
    report(parts.front().where,
           fmt::format("{} tetrahedra belong to no body; add a body for {}", without,
                       missing.empty() ? "them, or give a single body without `volume`" : "volume " + joined(missing)));
  }
  if (several > 0) {
    std::vector<std::string> sharing;
    Location where;
    for (std::size_t v = 0; v < groups.size(); ++v) {
      const auto of = volume_of_cells(mesh_, layout_, {groups[v]});
      bool shares = false;
      for (PetscInt c = 0; c < layout_.num_owned_cells; ++c) shares = shares || (result[c] == -2 && of[c] == 0);
      if (!any_rank(layout_.comm, shares)) continue;
      sharing.push_back("'" + title(groups[v]) + "'");
      where = parts[v].where;
    }
    report(where, fmt::format("{} tetrahedra are in several volumes of bodies ({}), but a tetrahedron can belong "
                              "to only one body; make the physical volumes disjoint",
                              several, joined(sharing)));
  }
  return result;
}

std::vector<char> Selections::cells(const Selection& part) {
  if (part.kind == Selection::Kind::everything) return std::vector<char>(layout_.num_local_cells, 1);
  std::vector<char> result(layout_.num_local_cells, 0);
  const PhysicalGroup* g = group(part);
  if (g == nullptr) return result;
  const auto of = volume_of_cells(mesh_, layout_, {*g});
  std::transform(of.begin(), of.end(), result.begin(), [](int v) { return v == 0; });
  return result;
}

void Selections::throw_if_errors() const {
  if (errors_.empty()) return;
  // What several keys refer to is missing once.
  std::vector<Diagnostic> once;
  for (const Diagnostic& error : errors_) {
    const auto is_same = [&](const Diagnostic& other) { return to_string(other) == to_string(error); };
    if (std::ranges::none_of(once, is_same)) once.push_back(error);
  }
  throw InputError(std::move(once));
}

std::vector<Diagnostic> Selections::unused_groups() const {
  std::vector<Diagnostic> notes;
  for (const auto& g : mesh_.groups) {
    if (!is_added(g) && std::find(used_.begin(), used_.end(), &g) == used_.end()) {
      notes.push_back(note(fmt::format("{} '{}' of the mesh is not used by the input", noun(g.dimension), title(g))));
    }
  }
  return notes;
}

}  // namespace pliant
