/// The nodes, facets and cells of the mesh that the input refers to.
#pragma once

#include "fem/selection.hpp"
#include "input/config.hpp"

#include <span>
#include <string>
#include <vector>

namespace pliant {

/// Resolves selections and keeps every error, so that all are reported at once. Its answers and errors are the same on
/// every rank, except for the lists of this rank's nodes and facets.
class Selections {
 public:
  /// `added`: volumes of the mesh that stand for rigid bodies without one. Only their names select them, and they have
  /// no surface.
  Selections(const Mesh& mesh, const NodeLayout& layout, std::span<const std::string> added = {});

  /// Owned nodes. Collective.
  std::vector<PetscInt> nodes(const Selection& part);
  /// Facets of a surface group, or of the whole surface of the bodies, or of the part in a box or region. Collective.
  FacetList facets(const Selection& part);
  /// Facets of the outer surface only: facets inside the mesh are an error at `where`, with the reason. Collective.
  FacetList outer_facets(const Selection& part, const Location& where, const std::string& reason);
  /// Whether the mesh has such a group. Not collective, and no error.
  bool has_group(Selection::Kind kind, const std::string& name) const;
  /// Edges of a curve. Collective.
  EdgeList edges(const Selection& part);
  /// Per local cell the index of the part that contains it. Every cell must be in exactly one. Collective.
  std::vector<int> cells(const std::vector<Selection>& parts);
  /// Per local cell: in the part or not. Collective.
  std::vector<char> cells(const Selection& part);

  void report(Location where, std::string message) {
    errors_.push_back({Severity::error, std::move(where), std::move(message)});
  }
  /// Throws InputError if there were errors. Not collective, but the same on every rank.
  void throw_if_errors() const;

  /// Notes of the groups that no selection has used so far.
  std::vector<Diagnostic> unused_groups() const;

 private:
  const PhysicalGroup* group(const Selection& part);
  bool is_added(const PhysicalGroup& group) const;
  /// The list without what belongs to added volumes.
  FacetList without_added(const FacetList& facets) const;

  const Mesh& mesh_;
  const NodeLayout& layout_;
  std::vector<std::string> added_;
  std::vector<char> is_added_node_;  // per local node; empty if none is
  std::vector<const PhysicalGroup*> used_;
  std::vector<Diagnostic> errors_;
};

/// The part in words: "surface 'clamp'".
std::string describe(const Selection& part);

}  // namespace pliant
