#include "study/mode.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Eigenvalues that differ by no more than this part are the same.
constexpr double same_eigenvalue = 1e-6;
/// Momenta below this part of the largest possible one are zero.
constexpr double no_momentum = 1e-5;
/// Components within this part of the largest count as largest.
constexpr double nearly_largest = 1e-3;

/// Modes with one eigenvalue.
struct EqualModes {
  std::span<Handle<Vec>> shapes;
  std::vector<std::array<double, num_momenta>> momenta;  ///< of each shape

  /// Combines the shapes from the first on such that the first alone has this momentum; false if none has any.
  bool gather(std::size_t first, std::size_t momentum);

 private:
  /// (a, b) = (c a + s b, c b - s a).
  void rotate(std::size_t a, std::size_t b, double c, double s);
};

void EqualModes::rotate(std::size_t a, std::size_t b, double c, double s) {
  Handle<Vec> before;
  check(VecDuplicate(shapes[a].get(), before.out()));
  check(VecCopy(shapes[a].get(), before.get()));
  check(VecAXPBY(shapes[a].get(), s, c, shapes[b].get()));
  check(VecAXPBY(shapes[b].get(), -s, c, before.get()));
  for (std::size_t k = 0; k < num_momenta; ++k) {
    const double of_a = momenta[a][k], of_b = momenta[b][k];
    momenta[a][k] = c * of_a + s * of_b;
    momenta[b][k] = c * of_b - s * of_a;
  }
}

bool EqualModes::gather(std::size_t first, std::size_t momentum) {
  double total = 0.0;
  for (std::size_t i = first; i < shapes.size(); ++i) total = std::hypot(total, momenta[i][momentum]);
  if (!(total > no_momentum)) return false;
  for (std::size_t i = first + 1; i < shapes.size(); ++i) {
    const double a = momenta[first][momentum], b = momenta[i][momentum], length = std::hypot(a, b);
    if (length > 0.0) rotate(first, i, a / length, b / length);
  }
  return true;
}

/// What decides on the sign of a shape: of the components that are largest, or nearly, that at the first place.
struct Leader {
  std::array<double, 3> place{};
  int component = 0;
  double value = 0.0;
};

void orient(Vec shape, const NodeLayout& layout) {
  double largest = 0.0;
  check(VecNorm(shape, NORM_INFINITY, &largest));
  std::vector<Leader> mine;
  const auto is_before = [](const Leader& a, const Leader& b) {
    return std::pair(a.place, a.component) < std::pair(b.place, b.component);
  };
  {
    const ConstArrayView values(shape);
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      for (int i = 0; i < 3; ++i) {
        const double value = values[3 * n + i];
        if (std::abs(value) < (1.0 - nearly_largest) * largest) continue;
        const Leader leader{layout.position(n), i, value};
        if (mine.empty()) {
          mine.push_back(leader);
        } else if (is_before(leader, mine.front())) {
          mine.front() = leader;
        }
      }
    }
  }
  const std::vector<Leader> all = gathered(layout.comm, mine);
  if (!all.empty() && std::ranges::min_element(all, is_before)->value < 0.0) check(VecScale(shape, -1.0));
}

Mode mode_of(double eigenvalue, double rounding) {
  Mode mode;
  mode.eigenvalue = eigenvalue;
  mode.kind = std::abs(eigenvalue) <= rounding ? Mode::Kind::rigid
              : eigenvalue < 0.0               ? Mode::Kind::unstable
                                               : Mode::Kind::vibrates;
  const double w = std::sqrt(std::abs(eigenvalue));
  if (mode.kind == Mode::Kind::vibrates) mode.frequency = w / (2.0 * std::numbers::pi);
  if (mode.kind == Mode::Kind::unstable) mode.growth_rate = w;
  return mode;
}

}  // namespace

std::string label_of(const Mode& mode, std::size_t number) {
  switch (mode.kind) {
    case Mode::Kind::rigid:
      return fmt::format("mode {}, 0 Hz", number);
    case Mode::Kind::unstable:
      return fmt::format("mode {}, unstable", number);
    case Mode::Kind::vibrates:
      break;
  }
  return fmt::format("mode {}, {:.5g} Hz", number, mode.frequency);
}

std::vector<Mode> modes_of(const Vibration& vibration, const NodeLayout& layout, const Eigenpairs& pairs) {
  std::vector<Handle<Vec>> shapes;
  for (const Handle<Vec>& x : pairs.vectors) {
    Handle<Vec> shape = make_vector(layout);
    vibration.expand(x.get(), shape.get());
    shapes.push_back(std::move(shape));
  }
  const auto is_next_same = [&](std::size_t i) {
    const double a = pairs.values[i], b = pairs.values[i + 1];
    return b - a <= std::max(same_eigenvalue * std::abs(b), pairs.roundings[i] + pairs.roundings[i + 1]);
  };
  std::vector<Mode> modes;
  for (std::size_t first = 0; first < shapes.size();) {
    std::size_t end = first + 1;
    while (end < shapes.size() && is_next_same(end - 1)) ++end;
    EqualModes group{std::span(shapes).subspan(first, end - first), {}};
    for (const Handle<Vec>& shape : group.shapes) group.momenta.push_back(vibration.momenta(shape.get()));
    for (std::size_t done = 0, momentum = 0; done < group.shapes.size() && momentum < num_momenta; ++momentum) {
      if (group.gather(done, momentum)) ++done;
    }
    for (std::size_t i = first; i < end; ++i) {
      Mode& mode = modes.emplace_back(mode_of(pairs.values[i], pairs.roundings[i]));
      for (std::size_t k = 0; k < 3; ++k) mode.effective_mass[k] = std::pow(group.momenta[i - first][k], 2);
      mode.shape = std::move(shapes[i]);
      update_ghosts(mode.shape.get());
      orient(mode.shape.get(), layout);
      update_ghosts(mode.shape.get());
      if (mode.kind == Mode::Kind::vibrates && vibration.is_damped()) {
        mode.damping_ratio = vibration.dissipation(mode.shape.get()) / (2.0 * std::sqrt(mode.eigenvalue));
      }
    }
    first = end;
  }
  return modes;
}

}  // namespace pliant
