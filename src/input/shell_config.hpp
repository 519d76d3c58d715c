/// Thin layers on surfaces, as the input describes them.
#pragma once

#include "input/material_config.hpp"
#include "input/selection.hpp"
#include "input/viscosity_config.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A curve at the edge of a shell that bends, across which its direction is held.
struct ClampedEdgeConfig {
  Selection part;                               ///< a curve
  std::optional<std::array<double, 3>> normal;  ///< of the plane of symmetry that it lies in, of any length
  Location where;
};

/// A membrane or shell on facets of the mesh.
struct ShellConfig {
  std::string name;
  Selection part;                                  ///< surface, box or where
  double thickness = 0.0;                          ///< before it was stretched onto the surface [m]
  std::optional<double> density;                   ///< [kg/m^3]; none: that of the library's material, or 0
  ElasticityConfig elasticity;                     ///< in plane stress
  std::vector<double> prestretch;                  ///< one number, or two along and across `direction`
  std::optional<std::array<double, 3>> direction;  ///< of any length
  double damping = 0.0;                            ///< viscous resistance per stiffness [s]
  std::vector<ViscosityConfig> viscosity;          ///< in parallel; kelvin-voigt or stiffness-proportional
  bool bends = false;                              ///< whether it resists bending too
  bool is_free = false;                            ///< a body of its own, whose triangles bound no tetrahedron
  std::vector<ClampedEdgeConfig> clamped;          ///< edges that hold their direction
  Location where;
};

}  // namespace pliant
