#include "energy/constraint/mechanism.hpp"

#include "energy/constraint/descent.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace pliant {
namespace {

constexpr auto no_part = static_cast<std::size_t>(-1);
/// By how much parts that soft bodies hold move where joints correct a position, relative to others.
constexpr double of_held = 1e-6;

/// The first unknown of each part, and the number of all.
std::vector<std::size_t> first_unknowns(const std::vector<std::unique_ptr<RigidPart>>& parts) {
  std::vector<std::size_t> first{0};
  for (const auto& part : parts) first.push_back(first.back() + part->hosts().size());
  return first;
}

}  // namespace

Mechanism::Mechanism(const NodeLayout& layout, std::vector<std::unique_ptr<RigidPart>> parts,
                     const std::vector<char>& are_held, std::vector<JointEquation> equations)
    : comm_(layout.comm),
      parts_(std::move(parts)),
      first_(first_unknowns(parts_)),
      joints_(std::move(equations), first_),
      part_of_node_(static_cast<std::size_t>(layout.num_owned_nodes), no_part) {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    hosts_.insert(hosts_.end(), parts_[p]->hosts().begin(), parts_[p]->hosts().end());
    for (const PetscInt a : parts_[p]->nodes()) {
      nodes_.push_back(a);
      part_of_node_[static_cast<std::size_t>(a)] = p;
    }
    size_ = std::max(size_, parts_[p]->size());
  }
  weights_ = Vector::Ones(static_cast<Eigen::Index>(hosts_.size()));
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const auto first = static_cast<Eigen::Index>(first_[p]);
    if (are_held[p]) weights_.segment(first, static_cast<Eigen::Index>(first_[p + 1]) - first).setConstant(of_held);
  }
  // The reference configuration, at the start of the run.
  reference_ = Vector::Zero(static_cast<Eigen::Index>(hosts_.size()));
  given_ = joints_.given(0.0, 1.0, 1.0, 1.0, Side::after);
  Vector g;
  joints_.configuration(motions(reference_), Along::columns, given_, g, G_ref_);
  joints_.scale_rows(G_ref_);
  choose_columns();
  preferred_ = columns_;
  hosts_.resize(static_cast<std::size_t>(columns_.cols()));
}

void Mechanism::set_rigidity(Rigidity rigidity) {
  rigidity_ = rigidity;
  for (const auto& part : parts_) part->set_rigidity(rigidity);
}

std::span<const double> Mechanism::of_part(const Vector& xi, std::size_t part) const {
  return std::span(xi.data(), static_cast<std::size_t>(xi.size()))
      .subspan(first_[part], first_[part + 1] - first_[part]);
}

std::vector<PartMotion> Mechanism::motions(const Vector& xi) const {
  std::vector<PartMotion> result;
  for (std::size_t p = 0; p < parts_.size(); ++p) result.push_back(parts_[p]->motion(of_part(xi, p)));
  return result;
}

bool Mechanism::approach(Vector& xi) const {
  const auto evaluate_at = [&](const Vector& at, Vector& h, JointDerivative& G) { evaluate(motions(at), h, G); };
  const auto moved = [](const Vector& from, const Vector& change) { return Vector(from + change); };
  return descend(xi, size_, weights_, evaluate_at, moved) != Descent::failed &&
         joints_.is_on_branch(motions(xi), given_);
}

bool Mechanism::solve(Vector& xi, std::vector<PartMotion>& parts, JointDerivative& G) const {
  parts = motions(xi);
  if (joints_.empty()) return true;
  constexpr int most_iterations = 50;
  constexpr double slow = 0.5;
  Vector h;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < most_iterations; ++i) {
    evaluate(parts, h, G);
    const double error = h.lpNorm<Eigen::Infinity>();
    if (!std::isfinite(error)) return false;
    // To rounding: until it does not fall any more.
    if (error <= joint_tolerance * size_ || (error <= std::sqrt(joint_tolerance) * size_ && error > slow * last)) {
      // Further on, other solutions of the same equations are as near.
      const bool is_near = level_ != Level::configuration || largest_rotation(xi) < std::numbers::pi;
      return is_near && joints_.is_on_branch(parts, given_);
    }
    last = error;
    xi -= across(G.factors(weights_, G_ref_).solve(h));
    // The equations are those of motions of about this size.
    if (!(xi - reference_).allFinite()) return false;
    parts = motions(xi);
  }
  return false;
}

Mechanism::Vector Mechanism::nearest_of_parts(Vec q) const {
  std::vector<double> xi;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_unknowns(q);
    xi.insert(xi.end(), nearest.begin(), nearest.end());
  }
  return Eigen::Map<const Vector>(xi.data(), static_cast<Eigen::Index>(xi.size()));
}

void Mechanism::begin_stage(const StagePoint& stage, Vec q) {
  solution_ = {};
  violation_.resize(0);
  lag_ = 0.0;
  for (const auto& part : parts_) part->begin_stage(stage, q);
  const bool is_last = stage.end_weight != 0.0;
  level_ = rigidity_ == Rigidity::of_configurations ? Level::configuration
           : is_last                                ? Level::end_of_step
                                                    : Level::acceleration;
  end_weight_ = stage.end_weight;
  start_.clear();
  advance_.clear();
  rest_.clear();
  for (const auto& part : parts_) {
    if (level_ == Level::acceleration) {
      start_.push_back(part->motion_of(stage.q0));
      advance_.push_back(sum_of(stage.dt, part->motion_of(stage.v0), {}));
    } else if (level_ == Level::end_of_step) {
      rest_.push_back(stage.end_rest != nullptr ? part->motion_of(stage.end_rest) : BodyMotion<double>{});
      rest_.back().centre = part->motion_of(q).centre;
    }
  }
  const double time = level_ == Level::end_of_step ? stage.end_time : stage.time;
  const double passed = time - stage.step_start;
  given_ = joints_.given(time, passed > 0.0 ? passed : stage.dt, stage.dt, stage.load_factor,
                         passed > 0.0 ? Side::before : Side::after);
  reference_ = nearest_of_parts(q);
  Vector h, solution = reference_;
  evaluate(motions(reference_), h, G_ref_);
  if (approach(solution)) {
    reference_ = solution;
    evaluate(motions(reference_), h, G_ref_);
  }
  choose_columns();
  if (stage.accepted == nullptr || is_ideal()) return;
  const Vector accepted = nearest_of_parts(stage.accepted);
  for (const auto& part : parts_) part->set_prescribed_fraction(0.0);
  JointDerivative G;
  evaluate(motions(accepted), violation_, G);
  for (const auto& part : parts_) part->set_prescribed_fraction(1.0);
}

void Mechanism::begin_end_of_step(Vec q) {
  solution_ = {};
  violation_.resize(0);
  lag_ = 0.0;
  for (const auto& part : parts_) part->begin_end_of_step(q);
  level_ = Level::configuration;
  reference_ = nearest_of_parts(q);
  Vector g;
  joints_.configuration(motions(reference_), Along::columns, given_, g, G_ref_);
  choose_columns();
  // The configuration fulfils the equations, of whatever time.
  Solution& solution = solution_;
  solution.unknowns.assign(hosts_.size(), 0.0);
  solution.xi = reference_;
  solution.parts = motions(reference_);
  solution.columns = solution.test_columns = columns_;
  combine(solution);
}

const Mechanism::Solution& Mechanism::at(std::span<const double> unknowns) const {
  Solution& solution = solution_;
  if (solution.xi.size() > 0 && std::ranges::equal(solution.unknowns, unknowns)) return solution;
  const auto size = static_cast<Eigen::Index>(unknowns.size());
  const Eigen::Map<const Vector> y(unknowns.data(), size);
  if (solution.xi.size() > 0 && solution.xi.allFinite()) {
    // From the last solution along its tangent.
    const Eigen::Map<const Vector> before(solution.unknowns.data(), size);
    solution.xi += solution.columns * (y - before);
  } else {
    solution.xi = reference_ + columns_ * y;
  }
  solution.unknowns.assign(unknowns.begin(), unknowns.end());
  JointDerivative G;
  if (!solution.xi.allFinite() || !solve(solution.xi, solution.parts, G)) {
    solution.xi.setConstant(std::numeric_limits<double>::quiet_NaN());
    solution.parts = motions(solution.xi);
    G = G_ref_;
    G.fill(std::numeric_limits<double>::quiet_NaN());
  }
  solution.columns = solution.test_columns = columns_;
  if (!joints_.empty()) {
    solution.test = G.factors(weights_, G_ref_);
    solution.columns -= across(solution.test.solve(G * columns_));
    solution.test_columns = solution.columns;
    if (!is_symmetric()) {
      Vector g;
      joints_.configuration(solution.parts, Along::test_columns, given_, g, G);
      solution.test = G.factors(weights_, G_ref_);
      solution.test_columns = columns_ - across(solution.test.solve(G * columns_));
    }
  }
  combine(solution);
  return solution;
}

void Mechanism::put_displacements(std::span<const double> unknowns, Vec q) const {
  const Solution& solution = at(unknowns);
  for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p]->put_displacements(of_part(solution.xi, p), q);
}

void Mechanism::put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const {
  const std::size_t p = part_of_node_[static_cast<std::size_t>(node)];
  const auto& motions = at(unknowns).motions[p];
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = motions[k].displacement(parts_[p]->reference(node));
}

void Mechanism::put_test_columns(std::span<const double> unknowns, PetscInt node,
                                 std::span<Vector3<double>> columns) const {
  const std::size_t p = part_of_node_[static_cast<std::size_t>(node)];
  const auto& motions = at(unknowns).virtual_motions[p];
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = motions[k].displacement(parts_[p]->reference(node));
}

void Mechanism::combine(Solution& solution) const {
  const auto combined = [&](std::size_t p, const Matrix& of_unknowns, const std::vector<BodyMotion<double>>& own) {
    const BodyMotion<double> still{solution.parts[p].value.centre, {}, {}};
    std::vector<BodyMotion<double>> result(static_cast<std::size_t>(of_unknowns.cols()), still);
    for (std::size_t k = 0; k < result.size(); ++k) {
      for (std::size_t l = 0; l < own.size(); ++l) {
        add(of_unknowns(static_cast<Eigen::Index>(first_[p] + l), static_cast<Eigen::Index>(k)), own[l], result[k]);
      }
    }
    return result;
  };
  solution.motions.resize(parts_.size());
  solution.virtual_motions.resize(parts_.size());
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    solution.motions[p] = combined(p, solution.columns, solution.parts[p].columns);
    solution.virtual_motions[p] =
        is_symmetric() ? solution.motions[p] : combined(p, solution.test_columns, solution.parts[p].test_columns);
  }
}

double Mechanism::largest_rotation(const Vector& xi) const {
  double largest = 0.0;
  for (std::size_t p = 0; p < parts_.size(); ++p) largest = std::max(largest, parts_[p]->rotation(of_part(xi, p)));
  return largest;
}

double Mechanism::rotation_by(std::span<const double> step, std::span<const double> unknowns) const {
  return largest_rotation(at(unknowns).columns *
                          Eigen::Map<const Vector>(step.data(), static_cast<Eigen::Index>(step.size())));
}

std::vector<double> Mechanism::nearest_unknowns(Vec q) const {
  Vector solution = nearest_of_parts(q);
  Vector on_joints = solution;
  if (approach(on_joints)) solution = on_joints;
  return coordinates(solution - reference_);
}

std::vector<double> Mechanism::nearest_rates(Vec v) const {
  std::vector<double> rates;
  for (const auto& part : parts_) {
    const auto nearest = part->nearest_rates(v);
    rates.insert(rates.end(), nearest.begin(), nearest.end());
  }
  return coordinates(Eigen::Map<const Vector>(rates.data(), static_cast<Eigen::Index>(rates.size())));
}

void Mechanism::start_stage(const StagePoint& stage) const {
  for (const auto& part : parts_) part->start_stage(stage);
}

std::vector<RigidPart::RigidState> Mechanism::states(const Step& step, Side side, Vec q, Vec v) const {
  std::vector<RigidPart::RigidState> result;
  for (const auto& part : parts_) result.push_back(part->state(step, side, q, v));
  return result;
}

std::vector<PartMotion> Mechanism::motions(const std::vector<RigidPart::RigidState>& states) const {
  std::vector<PartMotion> result;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    PartMotion& motion = result.emplace_back();
    motion.value = states[p].motion();
    for (std::size_t k = 0; k < parts_[p]->hosts().size(); ++k) {
      motion.columns.push_back(parts_[p]->virtual_motion(k, motion.value));
    }
  }
  return result;
}

bool Mechanism::fit_states(const Step& step, Side side, bool with_configurations,
                           std::vector<RigidPart::RigidState>& states) const {
  if (joints_.empty()) return false;
  using States = std::vector<RigidPart::RigidState>;
  const auto given_now = joints_.given(step.time, step.dt, 1.0, 1.0, side);
  const std::vector<double> none(first_.back(), 0.0);
  const auto evaluate_at = [&](const States& at, Vector& g, JointDerivative& G) {
    joints_.configuration(motions(at), Along::columns, given_now, g, G);
  };
  const auto moved = [&](States at, const Vector& change) {
    for (std::size_t p = 0; p < at.size(); ++p) {
      at[p] = parts_[p]->moved(at[p], of_part(change, p), std::span(none).first(first_[p + 1] - first_[p]));
    }
    return at;
  };
  const bool are_new = with_configurations && descend(states, size_, Vector::Ones(G_ref_.cols()), evaluate_at, moved) !=
                                                  Descent::nothing_to_do;
  Vector g;
  JointDerivative G;
  evaluate_at(states, g, G);
  std::vector<BodyMotion<double>> values, rates_of_parts;
  for (const auto& state : states) {
    values.push_back(state.motion());
    rates_of_parts.push_back(state.rate());
  }
  const Vector rates = joints_.rates(values, rates_of_parts, given_now);
  const Vector change = -G.smallest_change(rates, Vector::Ones(G.cols()));
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    states[p] = parts_[p]->moved(states[p], std::span(none).first(first_[p + 1] - first_[p]), of_part(change, p));
  }
  return are_new;
}

void Mechanism::complete_step(const Step& step, Vec q, Vec v) const {
  for (const auto& part : parts_) part->complete_step(step, q, v);
  auto fitted = states(step, Side::before, q, v);
  const bool are_new = fit_states(step, Side::before, true, fitted);
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    parts_[p]->put(fitted[p], are_new ? q : nullptr, v);
  }
}

void Mechanism::restart(const Step& step, Vec q, Vec v) const {
  auto fitted = states(step, Side::after, q, v);
  fit_states(step, Side::after, false, fitted);
  for (std::size_t p = 0; p < parts_.size(); ++p) parts_[p]->put(fitted[p], nullptr, v);
}

std::vector<const RigidPart*> Mechanism::parts() const {
  std::vector<const RigidPart*> result;
  for (const auto& part : parts_) {
    if (!is_symmetric()) result.push_back(part.get());
  }
  return result;
}

std::vector<BodyMotion<double>> Mechanism::allowed_velocities(std::size_t part) const {
  return at(std::vector<double>(hosts_.size(), 0.0)).motions[part];
}

void Mechanism::subtract_given(Vec v) const {
  for (const auto& part : parts_) part->subtract_given(v);
}

std::vector<Mechanism::Violation> Mechanism::violations(const Step& step, Vec q, Vec v) const {
  constexpr double rounding_of_places = 1e-6, rounding_of_velocities = 1e-5;  // of a few digits in an input
  const auto at = states(step, Side::after, q, v);
  const auto given_now = joints_.given(step.time, step.dt, 1.0, 1.0, Side::after);
  JointSystem::Given resting = given_now;
  for (auto& series : resting) series = {series.value, 0.0, 0.0};
  std::vector<BodyMotion<double>> values, rates_of_parts, resting_rates;
  double fastest = 0.0;
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    values.push_back(at[p].motion());
    rates_of_parts.push_back(at[p].rate());
    resting_rates.push_back(parts_[p]->state(q, v).rate());
    fastest = std::max(fastest, norm(at[p].velocity) + size_ * norm(at[p].omega));
  }
  Vector g;
  JointDerivative G;
  joints_.configuration(motions(at), Along::columns, given_now, g, G);
  const Vector moving = joints_.rates(values, rates_of_parts, given_now),
               still = joints_.rates(values, resting_rates, resting);
  std::vector<Violation> result(joints_.num_joints());
  for (Eigen::Index e = 0; e < g.size(); ++e) {
    auto& [distance, speed] = result[joints_.joint_of(e)];
    // Rows of G are of length 1: of directions, g is about the arm of the bodies times an angle.
    const double unit = joints_.is_length(e) ? 1.0 / joints_.scale(e) : 1.0;
    distance = std::hypot(distance, unit * g[e]);
    speed = std::hypot(speed, unit * std::min(std::abs(moving[e]), std::abs(still[e])));
  }
  for (auto& [distance, speed] : result) {
    if (distance <= rounding_of_places * size_) distance = 0.0;
    if (speed <= rounding_of_velocities * fastest) speed = 0.0;
  }
  return result;
}

std::array<RigidPart::RigidState, 2> Mechanism::states(const std::array<int, 2>& parts, Vec q, Vec v) const {
  std::array<RigidPart::RigidState, 2> result;
  for (std::size_t side = 0; side < 2; ++side) {
    if (parts[side] < 0) continue;
    result[side] = parts_[static_cast<std::size_t>(parts[side])]->state(q, v);
  }
  return result;
}

}  // namespace pliant
