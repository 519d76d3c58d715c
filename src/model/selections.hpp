/// The nodes, facets and cells of the mesh that the input refers to.
#pragma once

#include "fem/selection.hpp"
#include "input/config.hpp"

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace pliant {

/// Volumes of the mesh that are not of its file: bodies with only their names to select them.
struct AddedBodies {
  std::vector<std::string> names;
  std::vector<std::string> without_surface;  ///< of them, those that only stand for a body
  std::vector<std::string> shells;           ///< of them, free shells, whose facets are all that is of them
  /// The rods among them along curves of the mesh, each with its curve, whose nodes stand for a rod without cells.
  std::vector<std::pair<std::string, std::string>> on_curves;
};

/// Resolves selections and keeps every error, so that all are reported at once. Its answers and errors are the same on
/// every rank, except for the lists of this rank's nodes and facets.
class Selections {
 public:
  Selections(const Mesh& mesh, const NodeLayout& layout, AddedBodies added = {});

  /// Owned nodes. Collective.
  std::vector<PetscInt> nodes(const Selection& part);
  /// Facets of a surface group, or of the whole surface of the bodies, or of the part in a box or region. Collective.
  FacetList facets(const Selection& part);
  /// Facets of the whole surface of the bodies; there may be none where all bodies are rods. Collective.
  FacetList whole_surface() const;
  /// Facets of the outer surface only: facets inside the mesh are an error at `where`, with the reason. Collective.
  FacetList outer_facets(const Selection& part, const Location& where, const std::string& reason);
  /// Whether the mesh has such a group. Not collective, and no error.
  bool has_group(Selection::Kind kind, const std::string& name) const;
  /// The volume of this name or, if there is none, the surface; else an error. Not collective.
  std::optional<Selection> volume_or_surface(const Located<std::string>& name);
  /// Counts a group as used, or reports that the mesh has none. Not collective.
  void use(const Selection& part) { (void)group(part); }
  /// Edges of a curve. Collective.
  EdgeList edges(const Selection& part);
  /// Per local cell the index of the part that contains it. Every cell must be in exactly one. Collective.
  std::vector<int> cells(const std::vector<Selection>& parts);
  /// Per local cell: in the part or not. Collective.
  std::vector<char> cells(const Selection& part);

  void report(Location where, std::string message) {
    errors_.push_back({Severity::error, std::move(where), std::move(message)});
  }
  /// Owned nodes of free shells that no triangle has: the apexes of their cells. No other answer contains them. Not
  /// collective.
  std::vector<PetscInt> inert_nodes() const;
  /// Throws InputError if there were errors. Not collective, but the same on every rank.
  void throw_if_errors() const;

  /// Notes of the groups that no selection has used so far.
  std::vector<Diagnostic> unused_groups() const;

 private:
  /// The group of this name, else the one with this tag; nullptr if there is none.
  const PhysicalGroup* find_group(int dimension, const std::string& name) const;
  const PhysicalGroup* group(const Selection& part);
  bool is_added(const PhysicalGroup& group) const;
  /// The curve of a rod's group; nullptr if it is another's.
  const PhysicalGroup* curve_of(const PhysicalGroup& group) const;
  /// A node that is inert belongs to no triangle of a free shell.
  enum class Added : char { none, with_surface, without_surface, inert };
  /// The list without what belongs to added volumes of these kinds.
  FacetList without(const FacetList& facets, std::initializer_list<Added> kinds) const;

  const Mesh& mesh_;
  const NodeLayout& layout_;
  AddedBodies added_;
  std::vector<Added> added_node_;  // per local node; empty if none is
  std::vector<const PhysicalGroup*> used_;
  std::vector<Diagnostic> errors_;
};

/// The part in words: "surface 'clamp'".
std::string describe(const Selection& part);

}  // namespace pliant
