#include "run/shell_drawing.hpp"

#include "base/vector3.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// The least depth, relative to the square root of the triangle's area: what is thinner flickers in pictures.
constexpr double least_depth = 0.01;

Vector3<double> at(std::span<const double> values, PetscInt node) {
  const auto i = 3 * static_cast<std::size_t>(node);
  return {values[i], values[i + 1], values[i + 2]};
}

Vector3<double> mean(std::span<const double> values, const InertNode& inert) {
  Vector3<double> result{};
  for (std::size_t k = 0; k < 3; ++k) result = result + inert.weights[k] * at(values, inert.corners[k]);
  return result;
}

void set(std::span<double> values, PetscInt node, const Vector3<double>& x) {
  for (std::size_t i = 0; i < 3; ++i) values[3 * static_cast<std::size_t>(node) + i] = x[i];
}

Vector3<double> normal(std::span<const double> positions, const InertNode& inert) {
  const Vector3<double> a = at(positions, inert.corners[0]);
  return cross(at(positions, inert.corners[1]) - a, at(positions, inert.corners[2]) - a);
}

/// Away from the apex or towards it, at rest: the corners may be in either order.
double side_of_apex(const NodeLayout& layout, const InertNode& inert) {
  const Vector3<double> away = at(layout.coordinates, inert.node) - mean(layout.coordinates, inert);
  return dot(away, normal(layout.coordinates, inert)) > 0.0 ? 1.0 : -1.0;
}

}  // namespace

ShellDrawing::ShellDrawing(const Config& config, const Model& model) : layout_(model.layout()) {
  for (const ShellConfig& shell : config.shells) {
    if (!shell.is_free) continue;
    std::vector<char> is_of_shell;
    for (const int body : model.body_of_cell()) {
      is_of_shell.push_back(body >= 0 && model.body_names()[static_cast<std::size_t>(body)] == shell.name ? 1 : 0);
    }
    for (const InertNode& inert : inert_nodes(layout_, is_of_shell)) {
      const double size = std::sqrt(0.5 * norm(normal(layout_.coordinates, inert)));
      const double depth = std::max(0.5 * shell.thickness, least_depth * size);
      nodes_.push_back({inert, side_of_apex(layout_, inert) * inert.height * depth});
    }
  }
}

void ShellDrawing::place(std::span<double> positions) const {
  for (const auto& [inert, depth] : nodes_) {
    const Vector3<double> n = normal(positions, inert);
    const double length = norm(n);
    const Vector3<double> below = length > 0.0 ? (depth / length) * n : Vector3<double>{};
    set(positions, inert.node, mean(positions, inert) + below);
  }
}

void ShellDrawing::displace(std::span<double> displacements) const {
  if (nodes_.empty()) return;
  std::vector<double> before(layout_.coordinates), after(before);
  for (std::size_t i = 0; i < after.size(); ++i) after[i] += displacements[i];
  place(before);
  place(after);
  for (const Shown& shown : nodes_) {
    set(displacements, shown.inert.node, at(after, shown.inert.node) - at(before, shown.inert.node));
  }
}

void ShellDrawing::average(std::span<double> values, std::size_t width) const {
  for (const auto& [inert, depth] : nodes_) {
    for (std::size_t i = 0; i < width; ++i) {
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        sum += inert.weights[k] * values[width * static_cast<std::size_t>(inert.corners[k]) + i];
      }
      values[width * static_cast<std::size_t>(inert.node) + i] = sum;
    }
  }
}

}  // namespace pliant
