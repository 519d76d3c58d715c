/// Stress resultants and curvatures of shells at the states of a run.
#pragma once

#include "model/model.hpp"
#include "run/simulation.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace pliant {

/// What a triangle of a layer carries, or a node: in the axes of space, xx yy zz xy yz xz. Moments and curvatures are
/// positive where the outer side of the layer is stretched and convex.
struct LayerState {
  std::array<double, 6> force{};      ///< membrane force per length [N/m]
  std::array<double, 6> moment{};     ///< bending moment per length [N]
  std::array<double, 6> curvature{};  ///< of the surface [1/m]
};

/// The principal values in the layer of one of these, the larger first, and 0 across it.
std::array<double, 3> principal_values_in_layer(const std::array<double, 6>& tensor);

/// A triangle of a facet (fem/facet_triangles.hpp), which one rank counts.
struct LayerTriangle {
  LayerState state;            ///< the force is the mean over the facet
  double area = 0.0;           ///< at rest [m^2]
  bool is_counted = false;     ///< by this rank; all of its facets with an owned node are listed
  bool has_curvature = false;  ///< it bends, and has neighbours at all sides
};

class ShellFields {
 public:
  /// `model` outlives the object. Not collective.
  ShellFields(const Config& config, Model& model);

  /// The triangles of the facets of a shell, facet by facet in the order of its list. Collective.
  std::vector<LayerTriangle> of_triangles(std::size_t shell, const StepRecord& record) const;
  /// Means over the triangles around each local node, by their areas; zero where there are none. Where layers lie on
  /// one another, their forces and moments are added. `of_shell`: the triangles of a shell (of_triangles). Complete at
  /// owned nodes. Not collective, unless `of_shell` is.
  std::vector<LayerState> at_nodes(const std::function<const std::vector<LayerTriangle>&(std::size_t)>& of_shell) const;

 private:
  Model& model_;
  bool is_static_;
  std::vector<std::vector<double>> areas_;  // of the triangles of each shell [m^2]
};

}  // namespace pliant
