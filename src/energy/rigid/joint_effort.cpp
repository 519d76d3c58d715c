#include "energy/rigid/joint_effort.hpp"

#include "base/formula_tree.hpp"
#include "fem/straight_cell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr int ground = -1;

/// At which stop the coordinate is, the sign of it, and how far beyond; negative: between them.
std::pair<double, double> beyond_stops(const JointStops& stops, double coordinate) {
  const double below = stops.low - coordinate, above = coordinate - stops.high;
  return below > above ? std::pair{-1.0, below} : std::pair{1.0, above};
}

/// The energy that stops store [J].
double energy_of(const JointStops& stops, double coordinate) {
  const double beyond = beyond_stops(stops, coordinate).second, w = stops.rounding;
  if (beyond <= 0.0) return 0.0;
  if (beyond < w) return stops.stiffness * beyond * beyond * beyond / (6.0 * w);
  return stops.stiffness * (0.5 * beyond * (beyond - w) + w * w / 6.0);
}

/// The energy that a law stores at a coordinate less that at `from` [J]; none: less none.
double stored_energy(const JointLaw& law, double coordinate, std::optional<double> from) {
  if (const auto* stops = std::get_if<JointStops>(&law)) {
    return energy_of(*stops, coordinate) - (from ? energy_of(*stops, *from) : 0.0);
  }
  const auto* spring = std::get_if<JointSpring>(&law);
  if (spring == nullptr) return 0.0;
  // a^2 - b^2 = (a - b) (a + b) keeps the digits of small changes.
  const double now = coordinate - spring->rest;
  const double then = from ? *from - spring->rest : 0.0;
  return 0.5 * spring->stiffness * (now - then) * (now + then);
}

/// A way of the coordinate within a stage, whose rate is that of a difference: (s - start) per_time.
struct JointMove {
  double from, to;
  double start, per_time;  // per_time: 1/dt, or 0 where there are no rates
};

/// log(cosh(a + d) / cosh(a)); keeps the digits of small changes d.
double log_cosh_ratio(double a, double d) {
  if (std::abs(d) < 1.0) {
    const double half = std::sinh(0.5 * d);
    return std::log1p(2.0 * half * half + std::tanh(a) * std::sinh(d));
  }
  const auto log_cosh = [](double x) { return std::abs(x) + std::log1p(std::exp(-2.0 * std::abs(x))); };
  return log_cosh(a + d) - log_cosh(a);
}

/// What a motor lets go when the coordinate moves from one value to another: with u = k (target - s) + d (target' -
/// s'), the integral of -sat(u) - effort.
double potential_of(const JointMotor& motor, const JointMove& move, double time, double factor) {
  const TimeJet target = motor.target.derivatives(0.0, 0.0, 0.0, time, time);
  const double moved = move.to - move.from;
  const double stiffness = motor.stiffness + motor.damping * move.per_time;
  const double u = motor.stiffness * (factor * target.value - move.from) +
                   motor.damping * (factor * target.rate - move.per_time * (move.from - move.start));
  const double given = -factor * motor.effort(0.0, 0.0, 0.0, time) * moved;
  if (!motor.limit || stiffness == 0.0) return given - (u - 0.5 * stiffness * moved) * moved;
  const double limit = *motor.limit;
  return given + limit * limit / stiffness * log_cosh_ratio(u / limit, -stiffness * moved / limit);
}

/// The integral of a law's effort, with the opposite sign, along a move [J].
struct PotentialOf {
  JointMove move;
  double time, factor;

  double operator()(const JointSpring& spring) const { return stored_energy(spring, move.to, move.from); }
  double operator()(const JointStops& stops) const { return stored_energy(stops, move.to, move.from); }
  double operator()(const JointMotor& motor) const { return potential_of(motor, move, time, factor); }
  double operator()(const JointDamper& damper) const {
    const double sum = (move.to - move.start) + (move.from - move.start);
    return 0.5 * damper.coefficient * move.per_time * (move.to - move.from) * sum;
  }
  double operator()(const JointFriction& friction) const {
    if (move.per_time == 0.0) return 0.0;
    const double width = friction.stick_rate / move.per_time;
    return friction.largest * width * log_cosh_ratio((move.from - move.start) / width, (move.to - move.from) / width);
  }
  double operator()(const BearingFriction& bearing) const {
    return (*this)(JointFriction{*bearing.largest, bearing.stick_rate});
  }
};

struct EffortOf {
  double coordinate, rate, time, factor;

  JointEffortValue operator()(const JointSpring& spring) const {
    return {-spring.stiffness * (coordinate - spring.rest), -spring.stiffness, 0.0};
  }
  JointEffortValue operator()(const JointDamper& damper) const {
    return {-damper.coefficient * rate, 0.0, -damper.coefficient};
  }
  JointEffortValue operator()(const JointStops& stops) const {
    const auto [side, beyond] = beyond_stops(stops, coordinate);
    if (beyond <= 0.0) return {};
    const bool is_begun = beyond < stops.rounding;
    const double force = is_begun ? 0.5 * beyond * beyond / stops.rounding : beyond - 0.5 * stops.rounding;
    return {-side * stops.stiffness * force, -stops.stiffness * (is_begun ? beyond / stops.rounding : 1.0), 0.0};
  }
  JointEffortValue operator()(const JointFriction& friction) const {
    const double tanh = std::tanh(rate / friction.stick_rate);
    return {-friction.largest * tanh, 0.0, -friction.largest / friction.stick_rate * (1.0 - tanh * tanh)};
  }
  JointEffortValue operator()(const BearingFriction& bearing) const {
    return (*this)(JointFriction{*bearing.largest, bearing.stick_rate});
  }
  JointEffortValue operator()(const JointMotor& motor) const {
    const TimeJet target = motor.target.derivatives(0.0, 0.0, 0.0, time, time);
    const double u =
        motor.stiffness * (factor * target.value - coordinate) + motor.damping * (factor * target.rate - rate);
    double effort = u, slope = 1.0;
    if (motor.limit) {
      const double tanh = std::tanh(u / *motor.limit);
      effort = *motor.limit * tanh;
      slope = 1.0 - tanh * tanh;
    }
    return {effort + factor * motor.effort(0.0, 0.0, 0.0, time), -slope * motor.stiffness, -slope * motor.damping};
  }
};

/// The coordinate of a joint as a function of the displacements of its nodes, those of the first body first, and its
/// derivatives. Only three vectors of the bodies matter, each a weighted sum of displacements: derivatives are taken by
/// their nine numbers, and carried to the nodes by the weights.
class CoordinateOfNodes {
 public:
  CoordinateOfNodes(const JointEffort::Joint& joint, const std::array<std::vector<PetscInt>, 2>& nodes,
                    std::span<const double> X)
      : coordinate_(joint.coordinate), angle_(joint.angle.get()) {
    const JointVectors vectors = std::visit([](const auto& of) { return vectors_of(of); }, coordinate_);
    for (std::size_t d = 0; d < 3; ++d) places_[d] = vectors[d].at_start;
    for (std::size_t side = 0; side < 2; ++side) {
      if (nodes[side].empty()) continue;
      std::array<Vector3<double>, 4> x;
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t i = 0; i < 3; ++i) x[a][i] = X[3 * static_cast<std::size_t>(nodes[side][a]) + i];
      }
      const auto gradients = linear_gradients(x);
      for (std::size_t d = 0; d < 3; ++d) {
        if (vectors[d].body != side) continue;
        first_[d] = nodes_.size();
        const auto along = vectors[d].is_point ? vectors[d].at_start - x[0] : vectors[d].at_start;
        for (std::size_t a = 0; a < 4; ++a) weights_[d][a] = dot(gradients[a], along);
        if (vectors[d].is_point) weights_[d][0] += 1.0;
      }
      for (const PetscInt node : nodes[side]) nodes_.push_back(node);
    }
  }
  const std::vector<PetscInt>& nodes() const { return nodes_; }
  std::size_t size() const { return 3 * nodes_.size(); }

  double operator()(std::span<const double> u) const {
    const double coordinate = at(vectors(u));
    return angle_ != nullptr ? nearest_turn(coordinate, *angle_) : coordinate;
  }
  std::vector<double> gather(std::span<const double> q) const {
    std::vector<double> u;
    for (const PetscInt node : nodes_) {
      for (std::size_t i = 0; i < 3; ++i) u.push_back(q[3 * static_cast<std::size_t>(node) + i]);
    }
    return u;
  }
  std::vector<double> gradient(std::span<const double> u) const {
    Vectors<Dual<double>> x;
    const auto now = vectors(u);
    for (std::size_t k = 0; k < num_numbers; ++k) x[k / 3][k % 3] = now[k / 3][k % 3];
    std::vector<double> result(size(), 0.0);
    for (std::size_t k = 0; k < num_numbers; ++k) {
      x[k / 3][k % 3].slope = 1.0;
      const double slope = at(x).slope;
      x[k / 3][k % 3].slope = 0.0;
      for_nodes(k, [&](std::size_t entry, double weight) { result[entry] += weight * slope; });
    }
    return result;
  }
  /// By rows.
  std::vector<double> hessian(std::span<const double> u) const {
    Vectors<Dual<Dual<double>>> x;
    const auto now = vectors(u);
    for (std::size_t k = 0; k < num_numbers; ++k) x[k / 3][k % 3].value = Dual<double>(now[k / 3][k % 3], 0.0);
    std::vector<double> result(size() * size(), 0.0);
    for (std::size_t k = 0; k < num_numbers; ++k) {
      x[k / 3][k % 3].slope.value = 1.0;
      for (std::size_t l = 0; l < num_numbers; ++l) {
        x[l / 3][l % 3].value.slope = 1.0;
        const double bend = at(x).slope.slope;
        x[l / 3][l % 3].value.slope = 0.0;
        if (bend == 0.0) continue;
        for_nodes(k, [&](std::size_t row, double of_row) {
          for_nodes(
              l, [&](std::size_t column, double weight) { result[size() * row + column] += of_row * weight * bend; });
        });
      }
      x[k / 3][k % 3].slope.value = 0.0;
    }
    return result;
  }

 private:
  template <class T>
  using Vectors = std::array<Vector3<T>, 3>;
  static constexpr std::size_t num_numbers = 9;

  template <class T>
  T at(const Vectors<T>& x) const {
    return std::visit([&](const auto& joint) { return coordinate_at(joint, x); }, coordinate_);
  }
  Vectors<double> vectors(std::span<const double> u) const {
    Vectors<double> x = places_;
    for (std::size_t k = 0; k < num_numbers; ++k) {
      for_nodes(k, [&](std::size_t entry, double weight) { x[k / 3][k % 3] += weight * u[entry]; });
    }
    return x;
  }
  /// The entries of displacements on which number k of the vectors depends, with their weights.
  template <class F>
  void for_nodes(std::size_t k, F&& f) const {
    if (!first_[k / 3]) return;  // of the ground
    for (std::size_t a = 0; a < 4; ++a) f(3 * (*first_[k / 3] + a) + k % 3, weights_[k / 3][a]);
  }

  const JointCoordinate& coordinate_;
  const double* angle_;       // JointEffort::Joint::angle
  Vectors<double> places_{};  // of the vectors at the start
  std::array<std::array<double, 4>, 3> weights_{};
  std::array<std::optional<std::size_t>, 3> first_;  // node of each vector's body
  std::vector<PetscInt> nodes_;
};

/// Whether the effort in a stage follows from the coordinate alone, and has a potential.
bool has_potential(const JointLaw& law, JointRates rates) {
  if (rates == JointRates::differences) return true;
  const auto* motor = std::get_if<JointMotor>(&law);
  if (motor != nullptr) return motor->damping == 0.0;
  return std::holds_alternative<JointSpring>(law) || std::holds_alternative<JointStops>(law);
}

bool dissipates(const JointLaw& law) {
  return std::holds_alternative<JointDamper>(law) || std::holds_alternative<JointFriction>(law) ||
         std::holds_alternative<BearingFriction>(law);
}

bool has_rates(const LocalStage& stage) {
  return !stage.q0.empty() && stage.dt > 0.0;
}

/// A joint in a stage.
struct JointState {
  std::vector<double> u, velocity, slope;
  JointEffortValue effort;
  double coordinate = 0.0, rate = 0.0;
};

JointState state_of(const CoordinateOfNodes& coordinate, const JointEffort::Joint& joint, JointRates rates,
                    const LocalStage& stage, std::span<const double> q) {
  JointState state{coordinate.gather(q), std::vector<double>(coordinate.size(), 0.0), {}, {}};
  state.coordinate = coordinate(state.u);
  state.slope = coordinate.gradient(state.u);
  if (has_rates(stage)) {
    const auto start = coordinate.gather(stage.q0);
    if (rates == JointRates::differences) {
      state.rate = (state.coordinate - coordinate(start)) / stage.dt;
    } else if (!has_potential(joint.law, rates)) {
      for (std::size_t k = 0; k < start.size(); ++k) {
        state.velocity[k] = (state.u[k] - start[k]) / stage.dt;
        state.rate += state.slope[k] * state.velocity[k];
      }
    }
  }
  state.effort = joint_effort(joint.law, state.coordinate, state.rate, stage.time, stage.load_factor);
  return state;
}

}  // namespace

JointEffortValue joint_effort(const JointLaw& law, double coordinate, double rate, double time, double factor) {
  return std::visit(EffortOf{coordinate, rate, time, factor}, law);
}

JointBody joint_body(const NodeLayout& layout, const std::vector<int>& body_of_cell, int body) {
  JointBody result{body, {}, false};
  const PetscInt cell = largest_cell_of(layout, body_of_cell, body);
  if (cell < 0) return result;
  const auto corners = layout.nodes_of_cell(cell).first(4);
  result.is_owned = corners[0] < layout.num_owned_nodes;
  const bool has_some = std::ranges::any_of(corners, [&](PetscInt n) { return n < layout.num_owned_nodes; });
  if (has_some) result.nodes.assign(corners.begin(), corners.end());
  return result;
}

JointEffort::JointEffort(const std::vector<JointBody>& bodies, std::vector<Joint> joints, JointRates rates)
    : joints_(std::move(joints)), rates_(rates) {
  patches_.nodes_per_patch = 4;
  for (const JointBody& body : bodies) {
    const auto has_body = [&](const Joint& joint) {
      return joint.bodies[0] == body.key || joint.bodies[1] == body.key;
    };
    if (body.nodes.empty() || std::ranges::none_of(joints_, has_body)) continue;
    patches_.nodes.insert(patches_.nodes.end(), body.nodes.begin(), body.nodes.end());
    patches_.keys.push_back(body.key);
    patches_.tags.push_back(body.key);
    patches_.is_owned.push_back(body.is_owned ? 1 : 0);
  }
}

bool JointEffort::may_couple(int tag, int other) const {
  return std::ranges::any_of(joints_, [&](const Joint& joint) {
    return joint.bodies == std::array{tag, other} || joint.bodies == std::array{other, tag};
  });
}

std::string_view JointEffort::name() const {
  constexpr std::array<std::string_view, std::variant_size_v<JointLaw>> names{
      "joint-springs", "joint-dampers", "joint-motors", "joint-stops", "joint-friction", "bearing-friction"};
  return names[law().index()];
}

TermDeclaration JointEffort::declaration() const {
  TermDeclaration declaration;
  declaration.is_potential =
      std::ranges::all_of(joints_, [&](const Joint& joint) { return has_potential(joint.law, rates_); });
  declaration.account = std::holds_alternative<JointMotor>(law()) ? Account::load : Account::stored;
  declaration.dissipates = dissipates(law());
  declaration.refreezes = std::holds_alternative<BearingFriction>(law());
  declaration.symmetry = declaration.is_potential ? Symmetry::symmetric : Symmetry::nearly_symmetric;
  declaration.rotates_with_body = false;
  return declaration;
}

std::vector<JointEffort::Seen> JointEffort::seen(const NearPatches& near) const {
  std::vector<Seen> result;
  const auto& keys = near.patches.keys;
  for (const Joint& joint : joints_) {
    Seen one{&joint, {}, false};
    bool is_there = true;
    int least = std::numeric_limits<int>::max();
    for (std::size_t side = 0; side < 2; ++side) {
      if (joint.bodies[side] == ground) continue;
      const auto found = std::ranges::find(keys, static_cast<std::int64_t>(joint.bodies[side]));
      if (found == keys.end()) {
        is_there = false;
        break;
      }
      const auto patch = static_cast<std::size_t>(found - keys.begin());
      const auto nodes = near.patches.nodes_of(patch);
      one.nodes[side].assign(nodes.begin(), nodes.end());
      if (joint.bodies[side] >= least) continue;
      least = joint.bodies[side];
      one.is_counted = near.patches.is_owned[patch] != 0;
    }
    if (is_there) result.push_back(std::move(one));
  }
  return result;
}

double JointEffort::value(const LocalStage& stage, std::span<const double> q) const {
  if (!declaration().is_potential) return 0.0;
  const double per_time = has_rates(stage) ? 1.0 / stage.dt : 0.0;
  double sum = 0.0;
  for (const Seen& one : seen(*stage.near)) {
    if (!one.is_counted) continue;
    const CoordinateOfNodes coordinate(*one.joint, one.nodes, stage.near->coordinates);
    const auto at = [&](std::span<const double> place) { return coordinate(coordinate.gather(place)); };
    const double from = stage.reference().empty() ? 0.0 : at(stage.reference());
    const JointMove move{from, at(q), per_time > 0.0 ? at(stage.q0) : from, per_time};
    sum += std::visit(PotentialOf{move, stage.time, stage.load_factor}, one.joint->law);
  }
  return sum;
}

void JointEffort::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  for (const Seen& one : seen(*stage.near)) {
    const CoordinateOfNodes coordinate(*one.joint, one.nodes, stage.near->coordinates);
    const JointState state = state_of(coordinate, *one.joint, rates_, stage, q);
    for (std::size_t a = 0; a < coordinate.nodes().size(); ++a) {
      if (!stage.near->is_owned(coordinate.nodes()[a])) continue;
      for (std::size_t i = 0; i < 3; ++i) {
        r[3 * static_cast<std::size_t>(coordinate.nodes()[a]) + i] -= state.effort.effort * state.slope[3 * a + i];
      }
    }
  }
}

// r = -f(s, s') ds: -f d2s - ds (f_s ds + f_s' (ds / dt + d2s v))^T; v = 0 where rates are differences.
void JointEffort::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                              Projection projection) const {
  for (const Seen& one : seen(*stage.near)) {
    const CoordinateOfNodes coordinate(*one.joint, one.nodes, stage.near->coordinates);
    const JointState state = state_of(coordinate, *one.joint, rates_, stage, q);
    const std::size_t n = coordinate.size();
    const double per_time = stage.dt > 0.0 ? 1.0 / stage.dt : 0.0;
    std::vector<double> by_place(n), curvature(n * n, 0.0);
    const double along = state.effort.by_coordinate + state.effort.by_rate * per_time;
    for (std::size_t k = 0; k < n; ++k) by_place[k] = along * state.slope[k];
    if (projection == Projection::none) {
      curvature = coordinate.hessian(state.u);
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t l = 0; l < n; ++l)
          by_place[k] += state.effort.by_rate * curvature[n * k + l] * state.velocity[l];
      }
    }
    const auto& nodes = coordinate.nodes();
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      if (!stage.near->is_owned(nodes[a])) continue;
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        std::array<double, 9> block{};
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = 0; j < 3; ++j) {
            block[3 * i + j] = -state.slope[3 * a + i] * by_place[3 * b + j] -
                               state.effort.effort * curvature[n * (3 * a + i) + 3 * b + j];
          }
        }
        K.add(nodes[a], nodes[b], block);
      }
    }
  }
}

double JointEffort::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  double sum = 0.0;
  for (const Seen& one : seen(*at.near)) {
    if (!one.is_counted) continue;
    const CoordinateOfNodes coordinate(*one.joint, one.nodes, at.near->coordinates);
    sum += stored_energy(one.joint->law, coordinate(coordinate.gather(q)), std::nullopt);
  }
  return sum;
}

double JointEffort::dissipation(const LocalStage& stage, std::span<const double> q) const {
  double sum = 0.0;
  for (const Seen& one : seen(*stage.near)) {
    if (!one.is_counted || !dissipates(one.joint->law)) continue;
    const CoordinateOfNodes coordinate(*one.joint, one.nodes, stage.near->coordinates);
    const JointState state = state_of(coordinate, *one.joint, rates_, stage, q);
    sum -= state.effort.effort * state.rate;
  }
  return sum;
}

}  // namespace pliant
