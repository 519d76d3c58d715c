#include "model/free_rotation.hpp"

#include "input/analysis.hpp"
#include "input/loads.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <eigen3/Eigen/Dense>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Whether prescribed displacements are all that can hold bodies.
bool is_held_by_displacements_alone(const Config& config) {
  const auto is_displacement = [](const ConstraintConfig& constraint) {
    return std::holds_alternative<ConstraintConfig::Displacement>(constraint.kind) ||
           std::holds_alternative<ConstraintConfig::Symmetry>(constraint.kind);
  };
  return !config.contact && config.joints.empty() && config.tendons.empty() && config.rigid_bodies.empty() &&
         config.springs.empty() && config.rods.empty() && config.shells.empty() && config.cavities.empty() &&
         std::ranges::all_of(config.constraints, is_displacement) &&
         std::ranges::none_of(config.loads, [](const LoadConfig& load) { return foundation_of(load).has_value(); });
}

/// Numbers in text, with rounding errors as 0.
std::string in_words(const Eigen::Vector3d& x, double size) {
  constexpr double rounding = 1e-6;
  const auto rounded = [&](Eigen::Index i) { return std::abs(x[i]) > rounding * size ? x[i] : 0.0; };
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", rounded(0), rounded(1), rounded(2));
}

/// The mean of all nodes' places, and the largest distance from it.
struct Extent {
  Eigen::Vector3d middle;
  double size = 0.0;
};

Eigen::Vector3d place_of(const NodeLayout& layout, PetscInt n) {
  const auto X = layout.position(n);
  return {X[0], X[1], X[2]};
}

Extent extent_of(const NodeLayout& layout) {
  std::array<double, 4> sums{};  // of places, and their number
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const auto X = layout.position(n);
    for (std::size_t i = 0; i < 3; ++i) sums[i] += X[i];
    sums[3] += 1.0;
  }
  sum_in_place(layout.comm, sums);
  Extent extent{Eigen::Vector3d(sums[0], sums[1], sums[2]) / sums[3], 0.0};
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    extent.size = std::max(extent.size, (place_of(layout, n) - extent.middle).norm());
  }
  extent.size = maximum(layout.comm, extent.size);
  return extent;
}

/// Per component, the sum of the squares of what its prescribed entries see of a rigid motion v + w x X.
// The entry i of a node at X sees e_i . v + (X x e_i) . w.
std::vector<Matrix6> resistances(const NodeLayout& layout, const Components& components, std::span<const char> is_given,
                                 const Extent& extent) {
  constexpr std::size_t num_entries = 36;
  std::vector<double> entries(num_entries * static_cast<std::size_t>(components.count), 0.0);
  const auto matrix = [&](int c) {
    return Eigen::Map<Matrix6>(entries.data() + num_entries * static_cast<std::size_t>(c));
  };
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const auto component = components.of_node[static_cast<std::size_t>(n)];
    const Eigen::Vector3d X = (place_of(layout, n) - extent.middle) / extent.size;
    for (Eigen::Index i = 0; i < 3; ++i) {
      if (is_given[static_cast<std::size_t>(3 * n + i)] == 0) continue;
      Vector6 row;
      row << Eigen::Vector3d::Unit(i), X.cross(Eigen::Vector3d::Unit(i));
      matrix(component) += row * row.transpose();
    }
  }
  sum_in_place(layout.comm, entries);
  std::vector<Matrix6> found;
  for (int c = 0; c < components.count; ++c) found.emplace_back(matrix(c));
  return found;
}

/// About what a component can rotate, in words: a line or a point; nothing if it can do something else, or nothing.
std::optional<std::string> center_of_rotation(const Matrix6& resistance, const Extent& extent) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(resistance);
  constexpr double nothing = 1e-9;  // of what resists most
  const Vector6 squares = solver.eigenvalues();
  Eigen::Index number = 0;
  while (number < 6 && !(squares[number] > nothing * squares[5])) ++number;
  if (number == 0 || number > 3) return std::nullopt;
  // A point at rest in all of these motions: v + w x p = 0.
  Eigen::MatrixXd rates(3 * number, 3);
  Eigen::VectorXd velocities(3 * number);
  for (Eigen::Index k = 0; k < number; ++k) {
    const Eigen::Vector3d v = solver.eigenvectors().col(k).head<3>(), w = solver.eigenvectors().col(k).tail<3>();
    rates.block<3, 3>(3 * k, 0) << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
    velocities.segment<3>(3 * k) = v;
  }
  const Eigen::VectorXd p = rates.completeOrthogonalDecomposition().solve(-velocities);
  constexpr double rounding = 1e-4;
  if ((rates * p + velocities).norm() > rounding) return std::nullopt;  // a translation, or a screw
  const std::string place = in_words(extent.middle + extent.size * p, extent.size);
  if (number > 1) return fmt::format("the point {} m", place);
  Eigen::Vector3d axis = solver.eigenvectors().col(0).tail<3>().normalized();
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0.0) axis = -axis;
  return fmt::format("the line through {} m along {}", place, in_words(axis, 1.0));
}

}  // namespace

std::optional<Diagnostic> note_about_free_rotation(const Config& config, const NodeLayout& layout,
                                                   const Components& components, std::span<const char> is_given) {
  if (analysis_of(config) == Analysis::dynamic || !is_held_by_displacements_alone(config)) return std::nullopt;
  const Extent extent = extent_of(layout);
  const std::string_view what = components.count == 1 ? "the body" : "a part of the mesh";
  for (const Matrix6& resistance : resistances(layout, components, is_given, extent)) {
    const auto center = center_of_rotation(resistance, extent);
    if (!center) continue;
    return Diagnostic{
        Severity::note, config.time.method.where,
        fmt::format("the constraints leave {} free to rotate about {}: without inertia the stiffness is singular "
                    "there, and loads turn it to where they balance, which takes many iterations; hold one more "
                    "point, or use a method with inertia",
                    what, *center)};
  }
  return std::nullopt;
}

}  // namespace pliant
