/// What a model consists of besides its bodies, with places to show: for the page of `pliant check --html`.
#pragma once

#include "input/config.hpp"
#include "mesh/mesh.hpp"
#include "model/model.hpp"

#include <string>
#include <vector>

namespace pliant {

/// Something that the page lists and shows.
struct ModelItem {
  enum class Kind { group, constraint, load, shell, cavity, contact, probe, cells };
  Kind kind = Kind::group;
  std::string name;             ///< as messages name it
  std::string text;             ///< what the input says of it, or what was found
  std::vector<double> points;   ///< where it is at the start, xyz of each point [m]
  std::vector<double> vectors;  ///< forces at the points [N]; empty: none
};

std::string to_string(ModelItem::Kind kind);

/// The groups of the mesh, constraints, loads, shells, cavities, contact, probes and worst elements of the model of
/// `config` on the mesh; q: displacements at the start. The same on every rank. Collective.
std::vector<ModelItem> model_items(const Mesh& mesh, const Config& config, const Model& model, Vec q);

}  // namespace pliant
