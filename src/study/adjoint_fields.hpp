/// Parameters of an input that have a value in each cell, or at each node.
#pragma once

#include "io/result_writer.hpp"
#include "study/adjoint_run.hpp"
#include "study/varied_input.hpp"

#include <array>
#include <cstddef>
#include <string>
#include <vector>

namespace pliant {

/// Constants of elasticity (numbers, formulas and data of the mesh), of viscosity (numbers) and densities, of which
/// every cell of the body has a value of its own; initial displacements and velocities of the nodes, and their places.
class AdjointFields {
 public:
  /// `keys`: bodies.0.elasticity.youngs_modulus, bodies.0.viscosity.shear, bodies.0.density, initial.velocity,
  /// initial.displacement, mesh.nodes. `option`: where they were given, for messages. Throws InputError for other keys.
  /// Not collective.
  AdjointFields(std::string text, std::string file, std::vector<Override> changes, const std::vector<std::string>& keys,
                const std::string& option);

  /// The parameters of the fields that are constants, in their order, then those of the places of nodes.
  std::vector<AdjointRun::Parameter> parameters() const;
  std::size_t num_parameters() const { return constants_.size() + (by_nodes_ ? 9 : 0); }
  std::size_t num_constants() const { return constants_.size(); }
  bool by_nodes() const { return by_nodes_; }
  std::string key(std::size_t n) const;
  /// The value that was changed to differentiate: the number, or the factor 1 of a formula.
  double value_of_parameter(std::size_t n) const { return constants_[n].is_factor ? 1.0 : numbers_value(n); }

  /// Finds the values of the constants in the cells. Throws InputError if one is 0, and if nodes of a mesh with curved
  /// edges are to move. Collective.
  void find_values(const Mesh& mesh, const Model& model);

  /// Numbers on the owned cells or nodes.
  struct OnMesh {
    std::string name;
    FieldLocation location = FieldLocation::cell;
    int components = 1;
    std::vector<double> values;
  };
  /// Values and derivatives after the run was followed back: KEY and derivative(KEY). Values of other bodies are NaN.
  std::vector<OnMesh> on_mesh(const AdjointRun& run) const;

 private:
  struct Constant {
    std::string key;
    std::size_t body = 0;
    bool is_factor = false;      ///< a constant of elasticity, which is varied by a factor
    std::size_t place = 0;       ///< among the constants of the elasticity, or the numbers of varied_
    std::vector<double> values;  ///< of the owned cells
  };
  double numbers_value(std::size_t n) const { return varied_.numbers()[constants_[n].place].value; }

  VariedInput varied_;  // the constants that are numbers
  std::vector<Constant> constants_;
  bool by_displacement_ = false, by_velocity_ = false, by_nodes_ = false;
};

/// The mean of the corners of a local cell [m].
std::array<double, 3> centroid(const NodeLayout& layout, PetscInt cell);

}  // namespace pliant
