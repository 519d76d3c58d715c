#include "model/method_warnings.hpp"

#include "base/error.hpp"
#include "base/tensor.hpp"
#include "base/text.hpp"
#include "model/shells.hpp"
#include "petsc/collective.hpp"
#include "time/linear_stability.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Growth of the energy by this factor makes every vibration that a run excites visible.
constexpr double certain_growth = 1e4;
/// Fraction of the energy of the rotation that is certainly too much for a single step.
constexpr double certain_stretch = 0.25;
/// The same fraction, where the energy grows by at most a tenth in many steps (measured with a cube).
constexpr double harmless_stretch = 0.03;

double largest_root(const Method& method, double phase) {
  double largest = 0.0;
  for (const auto& zeta : amplification(method, {0.0, phase})) largest = std::max(largest, std::abs(zeta));
  return largest;
}

struct Rotation {
  double rate = 0.0;    ///< [rad/s]
  double energy = 0.0;  ///< per mass [J/kg]
};

/// The rigid rotation nearest to the initial velocity of a body, with equal weights of its nodes. Collective.
Rotation initial_rotation(const Config& config, const MotionAtStart& at, int body) {
  const NodeLayout& layout = at.layout;
  std::vector<char> is_in(static_cast<std::size_t>(layout.num_owned_nodes), 0);
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (at.body_of_cell[static_cast<std::size_t>(c)] != body) continue;
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      if (n < layout.num_owned_nodes) is_in[static_cast<std::size_t>(n)] = 1;
    }
  }
  struct Sums {
    double count = 0.0;
    std::array<double, 3> X{}, v{}, moment{};
    Tensor3<double> XX{};
  } sums;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    if (!is_in[static_cast<std::size_t>(n)]) continue;
    const auto X = layout.position(n);
    std::array<double, 3> v{};
    for (int i = 0; i < 3; ++i) v[i] = config.initial.velocity[i](X[0], X[1], X[2], 0.0);
    sums.count += 1.0;
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      sums.X[i] += X[i];
      sums.v[i] += v[i];
      sums.moment[i] += X[j] * v[k] - X[k] * v[j];
      for (int l = 0; l < 3; ++l) sums.XX(i, l) += X[i] * X[l];
    }
  }
  const auto total = [&](double& x) { x = sum(layout.comm, x); };
  total(sums.count);
  for (int i = 0; i < 3; ++i) {
    for (double* x : {&sums.X[i], &sums.v[i], &sums.moment[i]}) total(*x);
    for (int l = 0; l < 3; ++l) total(sums.XX(i, l));
  }
  if (!(sums.count > 0.0)) return {};
  // About the centre: inertia I = tr(C) 1 - C of the second moments C, spin I^-1 (moment).
  Tensor3<double> C{};
  std::array<double, 3> moment{};
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    moment[i] = (sums.moment[i] - (sums.X[j] * sums.v[k] - sums.X[k] * sums.v[j]) / sums.count) / sums.count;
    for (int l = 0; l < 3; ++l) C(i, l) = (sums.XX(i, l) - sums.X[i] * sums.X[l] / sums.count) / sums.count;
  }
  const Tensor3<double> inertia = add_to_diagonal(-1.0 * C, trace(C));
  const double size = trace(inertia);
  if (!(det(inertia) > 1e-9 * size * size * size)) return {};  // nodes on one line
  const Tensor3<double> inverse = (1.0 / det(inertia)) * transpose(cofactor(inertia));
  std::array<double, 3> spin{};
  for (int i = 0; i < 3; ++i) {
    for (int l = 0; l < 3; ++l) spin[i] += inverse(i, l) * moment[l];
  }
  return {std::hypot(spin[0], spin[1], spin[2]),
          0.5 * (spin[0] * moment[0] + spin[1] * moment[1] + spin[2] * moment[2])};
}

/// Warns of a free body that rotates and is stretched by the steps, which none of its vibrations can follow. It stores
/// at least 2 mu stretch^2 per volume, with the shear modulus mu and the stretch in the plane of the rotation.
std::optional<Diagnostic> rotation_warning(const Config& config, const Method& method, const MotionAtStart& at) {
  if (method.num_steps > 1 || method.stiffly_accurate || !config.constraints.empty()) return std::nullopt;
  const double dt = config.time.step;
  double worst = 0.0, angle = 0.0;
  for (std::size_t b = 0; b < at.shear_waves.size(); ++b) {
    const Rotation rotation = initial_rotation(config, at, static_cast<int>(b));
    if (!(rotation.energy > 0.0) || rotation.rate * dt > 1.0) continue;  // no small angle
    const double stretch = stretch_of_rotation(method, rotation.rate * dt), wave = at.shear_waves[b];
    const double part = 2.0 * wave * wave * stretch * stretch / rotation.energy;
    if (part <= worst) continue;
    worst = part;
    angle = rotation.rate * dt;
  }
  if (worst < certain_stretch) return std::nullopt;
  // The stretch is of second order in the step, its energy of fourth order.
  const double sound = dt * std::pow(harmless_stretch / worst, 0.25);
  return Diagnostic{
      Severity::warning, config.time.method.where,
      fmt::format(
          "'{}' cannot take steps of {} s here: the body rotates by {:.2g} degrees in a step, and the method then "
          "stretches it with {:.2g} times the energy of the rotation; take steps below {:.1g} s, or a stiffly accurate "
          "method: bdf2, dirk22, dirk33",
          method.name, format_number(dt), angle * 180.0 / std::numbers::pi, worst, sound)};
}

/// Whether any body vibrates without viscosity.
bool has_undamped_body(const Config& config) {
  return std::ranges::any_of(config.bodies, [&](const BodyConfig& body) {
    const auto shell = std::ranges::find(config.shells, body.part.name, &ShellConfig::name);
    if (body.is_shell && shell != config.shells.end()) return !viscosity_of(*shell).is_any();
    return !body.is_rigid && body.viscosity.empty();
  });
}

/// Warns of vibrations of the body that the method amplifies.
std::optional<Diagnostic> vibration_warning(const Config& config, const Method& method, const MotionAtStart& at) {
  if (method.stability != Stability::not_a_stable || !has_undamped_body(config)) return std::nullopt;
  const double dt = config.time.step;
  const auto& b = at.mesh.bounds;
  const double length = std::max({b[3] - b[0], b[4] - b[1], b[5] - b[2]});
  // From half a wave in the length of the body to about the fastest vibration of the mesh. Slower ones exist, too.
  const double lowest = std::numbers::pi * at.slowest_wave / length, highest = 2.0 * at.slowest_wave / at.mesh.min_edge;
  if (!(lowest < highest)) return std::nullopt;
  const auto [factor, phase] = fastest_growth(method, lowest * dt, highest * dt);
  const double decades = 2.0 * std::log10(factor) * config.time.end / dt;
  if (decades < std::log10(certain_growth)) return std::nullopt;
  return Diagnostic{
      Severity::warning, config.time.method.where,
      fmt::format(
          "'{}' is not A-stable: in steps of {} s vibrations of the body near {:.2g} Hz grow by {:.2g} % or more in a "
          "step, and their energy over the run by a factor of {} or more; give the bodies a viscosity "
          "(stiffness-proportional, "
          "time: {:.2g} s), or choose another method",
          method.name, format_number(dt), phase / dt / (2.0 * std::numbers::pi), 100.0 * (factor - 1.0),
          decades > 30.0 ? "1e+30" : fmt::format("{:.0e}", std::pow(10.0, decades)), 0.2 * dt)};
}

}  // namespace

double stretch_of_rotation(const Method& method, double angle) {
  const auto stretch = [&](std::span<const double> weights) {
    std::complex<double> end = 1.0;
    for (std::size_t i = 0; i < weights.size(); ++i) end += weights[i] * (std::polar(1.0, method.c[i] * angle) - 1.0);
    return std::abs(std::abs(end) - 1.0);
  };
  double largest = stretch(method.bt);
  if (!method.symplectic) return largest;
  for (const auto& weights : method.At) largest = std::max(largest, stretch(weights));
  return largest;
}

FastestGrowth fastest_growth(const Method& method, double lowest, double highest) {
  constexpr int num_samples = 200;
  FastestGrowth fastest;
  for (int k = 0; k <= num_samples; ++k) {
    const double phase = lowest * std::pow(highest / lowest, static_cast<double>(k) / num_samples);
    const double factor = largest_root(method, phase);
    if (factor > fastest.factor) fastest = {factor, phase};
  }
  return fastest;
}

std::vector<Diagnostic> warnings_about_method(const Config& config, const MotionAtStart& at) {
  const Method* method = method_of(config.time);
  if (method == nullptr || config.time.adaptive) return {};
  std::vector<Diagnostic> warnings;
  for (const auto& warning : {rotation_warning(config, *method, at), vibration_warning(config, *method, at)}) {
    if (warning) warnings.push_back(*warning);
  }
  return warnings;
}

std::optional<Diagnostic> note_about_growth(const Config& config) {
  const Method* method = method_of(config.time);
  if (method == nullptr || method->stability != Stability::not_a_stable || !has_undamped_body(config)) {
    return std::nullopt;
  }
  return note(
      fmt::format("{} is not A-stable: undamped vibrations grow; give the bodies a viscosity, or choose another method",
                  method->name.empty() ? "the method" : method->name));
}

}  // namespace pliant
