/// Warnings about time integration methods that certainly cannot take the steps they are given.
#pragma once

#include "fem/layout.hpp"
#include "input/config.hpp"
#include "mesh/report.hpp"

#include <optional>
#include <span>
#include <vector>

namespace pliant {

/// What is known about the motion before it starts.
struct MotionAtStart {
  const NodeLayout& layout;
  const std::vector<int>& body_of_cell;  ///< of each local cell
  std::span<const double> shear_waves;   ///< speed in each body's stiffest part; 0 without mass [m/s]
  double slowest_wave = 0.0;             ///< shear waves of the softest body [m/s]
  const MeshReport& mesh;
};

/// Stretch of a stiff body that a step rotates by `angle` [rad], which the method alone causes: at stages the body has
/// its size, but the step ends at a combination of them.
///
///     y_{n+1} - y* = sum_i bt_i (Y_i - y*),   |Y_i| = |y*|:   stretch = |1 + sum_i bt_i (exp(i c_i angle) - 1)| - 1
///
/// It is 0 where the last stage ends the step. Symplectic methods are steps of the midpoint rule one after another, and
/// a stage starts where one ends: the largest counts, Y_i0 - y* = sum_j At_ij (Y_j - y*). Methods of one past state.
double stretch_of_rotation(const Method& method, double angle);

/// The factor by which a step multiplies the amplitude of the undamped vibrations that grow most, among those of
/// lowest dt <= omega dt <= highest dt.
struct FastestGrowth {
  double factor = 1.0;
  double phase = 0.0;  ///< omega dt
};
FastestGrowth fastest_growth(const Method& method, double lowest, double highest);

/// Steps must be equal. Collective.
std::vector<Diagnostic> warnings_about_method(const Config& config, const MotionAtStart& at);
/// A note where a method that is not A-stable advances bodies without a viscosity.
std::optional<Diagnostic> note_about_growth(const Config& config);

}  // namespace pliant
