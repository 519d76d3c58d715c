/// The sets and surfaces of an Abaqus file while it is read.
#pragma once

#include "mesh/formats/abaqus_cards.hpp"
#include "mesh/formats/mesh_assembly.hpp"

#include <map>
#include <span>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace pliant {

/// A set of labels of nodes or elements.
struct AbaqusSet {
  std::string name;   // as in the file
  std::string scope;  // the part in capitals and a dot; empty for the assembly, and in files without parts
  bool is_internal = false;
  std::size_t line = 0;
  std::vector<std::size_t> labels;
};

/// Leaves each label once.
void make_unique(AbaqusSet& set);
/// Adds labels. Those that are there twice go when memory runs short.
void add_labels(AbaqusSet& set, std::span<const std::size_t> more);

/// Sets of one kind by name; the same name again continues a set.
class AbaqusSets {
 public:
  AbaqusSet& add(const std::string& scope, const std::string& name, std::size_t line);
  /// The set of that name in the scope, or else of the assembly, or by a qualified name ("Part-1-1.left"); null if
  /// there is none.
  const AbaqusSet* find(const std::string& scope, const std::string& name) const;
  /// The name of its group: that of the set, after that of its part if the assembly has another set of that name.
  std::string title(const AbaqusSet& set) const;
  const std::vector<AbaqusSet>& all() const { return sets_; }

 private:
  std::vector<AbaqusSet> sets_;
  std::map<std::string, std::size_t> index_;  // by scope and name in capitals
};

/// A line of *SURFACE: a set or a label, and a side.
struct AbaqusSide {
  std::string of;
  std::string side;  // in capitals; may be empty
  std::size_t line = 0;
};

struct AbaqusSurface {
  std::string name;
  std::string scope;
  std::vector<AbaqusSide> sides;
};

/// What was read, before it becomes groups.
struct AbaqusModel {
  MeshAssembly mesh;
  std::unordered_set<std::size_t> nodes;
  std::unordered_map<std::size_t, std::size_t> elements;  // index in the mesh by label; left_out for others
  AbaqusSets element_sets, node_sets;
  std::vector<AbaqusSurface> surfaces;

  static constexpr std::size_t left_out = static_cast<std::size_t>(-1);
};

/// Makes groups of all sets and surfaces. Throws MeshDefect, with the line, where they name what the file lacks.
void assign_groups(AbaqusModel& model, const LineReader& lines);

}  // namespace pliant
