#include "energy/constraint/rigid_part.hpp"

#include "base/dual.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "material/spectral.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "time/rotation.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Nodes closer to one line than this fraction of their size do not determine a rotation about it.
constexpr double collinearity = 1e-6;
/// Relative to the size: displacements that are rigid to this tolerance are left unchanged, which keeps their digits.
constexpr double rigidity_tolerance = 1e-13;

/// a x each column of A.
Tensor3<double> cross_columns(const Vector3<double>& a, const Tensor3<double>& A) {
  Tensor3<double> result;
  for (int j = 0; j < 3; ++j) {
    const Vector3<double> column = cross(a, {A(0, j), A(1, j), A(2, j)});
    for (int i = 0; i < 3; ++i) result(i, j) = column[static_cast<std::size_t>(i)];
  }
  return result;
}

}  // namespace

std::optional<std::string> why_not_rigid(const NodeLayout& layout, std::span<const PetscInt> nodes,
                                         const RigidMotion& motion, FreeRotation rotation) {
  const Tensor3<double> moment = AffineFit(layout, nodes, motion.centre).second_moment();
  const double size = trace(moment);
  if (size == 0.0) return "has a single node, which has no rotation";
  const Tensor3<double> inertia = add_to_diagonal(-1.0 * moment, size);  // of nodes of mass 1
  if (rotation == FreeRotation::about_axis) {
    if (dot(motion.axis, matvec(inertia, motion.axis)) > collinearity * collinearity * size) return std::nullopt;
    return "lies on one line along the axis, about which it does not turn";
  }
  // For points on a line one moment of inertia vanishes, and the others are `size` each.
  if (det(inertia) > collinearity * collinearity * size * size * size) return std::nullopt;
  return "lies on one line, about which its rotation is undefined";
}

bool centre_is_off_plane(const NodeLayout& layout, std::span<const PetscInt> nodes, const RigidMotion& motion) {
  const AffineFit fit(layout, nodes, motion.centre);
  const auto& r = fit.mean_arm();
  const Vector3<double> off = r - matvec(fit.in_plane(), r);
  return dot(off, off) > collinearity * collinearity * trace(fit.second_moment());
}

RigidPart::RigidPart(const NodeLayout& layout, std::vector<PetscInt> nodes, const RigidMotion& motion,
                     FreeRotation rotation)
    : layout_(&layout), nodes_(std::move(nodes)), motion_{{}, motion} {
  for (std::size_t i = 0; i < 3; ++i) {
    if (!motion.translation[i]) free_components_.push_back(i);
  }
  if (rotation == FreeRotation::about_axis) {
    axes_ = {motion.axis};
    fit_.emplace(layout, nodes_, motion.centre, motion.axis);
  } else {
    axes_ = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    fit_.emplace(layout, nodes_, motion.centre);
    // Any centre will do then: use one in the plane of the nodes.
    if (is_free()) {
      motion_.rigid->centre = motion.centre + fit_->mean_arm();
      fit_.emplace(layout, nodes_, motion_.rigid->centre);
    }
  }

  // The first two nodes hold the unknowns.
  std::vector<PetscInt> mine;
  for (const PetscInt a : nodes_) mine.push_back(layout.global_node(a));
  const auto all = gathered(layout.comm, mine);
  size_ = std::sqrt(trace(fit_->second_moment()) / static_cast<double>(all.size()));
  for (const std::size_t i : free_components_) hosts_.push_back(3 * all[0] + static_cast<PetscInt>(i));
  for (std::size_t k = 0; k < axes_.size(); ++k) hosts_.push_back(3 * all[1] + static_cast<PetscInt>(k));
}

Placement RigidPart::nearest(Vec q) const {
  const Vector3<double>& centre = motion_.rigid->centre;
  return axes_.size() == 1 ? nearest_placement_about(axes_[0], *layout_, nodes_, centre, q)
                           : nearest_placement(*layout_, nodes_, centre, q);
}

// With F0 = I + h, dt F0' = g and B = 3/4 I + b, quantities of the size of the displacements are kept apart:
// 16 S^2 = I + 16 Z, Z = 3/4 (b + b^T) + b^T b - (h + h^T + h^T h) / 2.
RigidPart::Shape RigidPart::shape_of(const StagePoint& stage) const {
  if (rigidity_ == Rigidity::of_configurations) return {};
  if (stage.end_weight != 0.0) {
    Shape shape;
    shape.weight = 1.0 / stage.end_weight;
    shape.arms = shape.weight * identity<double>();
    if (stage.end_rest != nullptr) {
      shape.drift = -shape.weight * (*fit_)(*layout_, nodes_, stage.end_rest).gradient;
    }
    return shape;
  }
  const Tensor3<double> h = (*fit_)(*layout_, nodes_, stage.q0).gradient;
  const Tensor3<double> g = stage.dt * (*fit_)(*layout_, nodes_, stage.v0).gradient;
  const Tensor3<double> b = 0.25 * (3.0 * h + g);
  const Tensor3<double> Z =
      0.75 * (b + transpose(b)) + matmul(transpose(b), b) - 0.5 * (h + transpose(h) + matmul(transpose(h), h));
  const auto eigen = eigen_decomposition(matmul(fit_->in_plane(), matmul(Z, fit_->in_plane())));
  Tensor3<double> s{};  // S - I / 4; NaN if no rotation fulfils the equation: the step is too long
  for (int k = 0; k < 3; ++k) {
    const Vector3<double> n = {eigen.vectors(0, k), eigen.vectors(1, k), eigen.vectors(2, k)};
    const double z = eigen.values[static_cast<std::size_t>(k)];
    s = s + (4.0 * z / (1.0 + std::sqrt(1.0 + 16.0 * z))) * outer(n, n);
  }
  return {b + s, add_to_diagonal(s, 0.25), 0.25};
}

// F - B = R S for the R that makes sum |x_a - B r_a - R S r_a|^2 least.
Quaternion RigidPart::nearest_rotation(const Tensor3<double>& gradient) const {
  const Tensor3<double> A = matmul(matmul(gradient - shape_.drift + shape_.arms, fit_->second_moment()), shape_.arms);
  return axes_.size() == 1 ? rotation_nearest_to(A, axes_[0]) : rotation_nearest_to(A);
}

void RigidPart::begin_end_of_step(Vec q) {
  shape_ = {};
  reference_ = nearest(q).rotation;
  at_ = {};
}

void RigidPart::begin_stage(const StagePoint& stage, Vec q) {
  const GivenKinematics given = given_at(stage);
  for (int i = 0; i < 3; ++i) end_translation_[i] = motion_.gives(i) ? given(i, motion_.rigid->centre).u : 0.0;
  given_translation_ = start_translation_ = end_translation_;
  if (stage.accepted != nullptr && !is_ideal()) start_translation_ = nearest(stage.accepted).translation;
  shape_ = shape_of(stage);
  reference_ = nearest_rotation((*fit_)(*layout_, nodes_, q).gradient);
  at_ = {};
}

std::vector<double> RigidPart::nearest_unknowns(Vec q) const {
  const AffineMotion motion = (*fit_)(*layout_, nodes_, q);
  const Quaternion R = nearest_rotation(motion.gradient);
  const Vector3<double>& r = fit_->mean_arm();
  const Vector3<double> translation = motion.translation + matvec(motion.gradient - shape_.drift, r) -
                                      Placement{{}, R}.displacement(matvec(shape_.arms, r));
  const Vector3<double> theta = logarithm(product(R, inverse(reference_)));
  std::vector<double> result;
  for (const std::size_t i : free_components_) result.push_back(translation[i]);
  for (const auto& axis : axes_) result.push_back(shape_.weight * size_ * dot(theta, axis));
  return result;
}

std::array<Vector3<double>, 2> RigidPart::nearest_velocities(const Placement& placement, Vec v) const {
  const Vector3<double>& centre = motion_.rigid->centre;
  return axes_.size() == 1 ? nearest_velocity_about(axes_[0], *layout_, nodes_, centre, placement, v)
                           : nearest_velocity(*layout_, nodes_, centre, placement, v);
}

std::vector<double> RigidPart::nearest_rates(Vec v) const {
  const auto [velocity, omega] = nearest_velocities({}, v);
  std::vector<double> result;
  for (const std::size_t i : free_components_) result.push_back(velocity[i]);
  for (const auto& axis : axes_) result.push_back(size_ * dot(omega, axis));
  return result;
}

Vector3<double> RigidPart::rotation_vector(std::span<const double> unknowns) const {
  Vector3<double> theta{};
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    theta = theta + (unknowns[free_components_.size() + k] / (shape_.weight * size_)) * axes_[k];
  }
  return theta;
}

Placement RigidPart::placement(std::span<const double> unknowns) const {
  Placement result{given_translation_, product(exponential(rotation_vector(unknowns)), reference_)};
  for (std::size_t k = 0; k < free_components_.size(); ++k) result.translation[free_components_[k]] = unknowns[k];
  return result;
}

void RigidPart::put_displacements(std::span<const double> unknowns, Vec q) const {
  const Placement at = placement(unknowns);
  const ArrayView entries(q);
  for (const PetscInt a : nodes_) {
    const auto u = at.displacement(matvec(shape_.arms, arm(a))) + matvec(shape_.drift, arm(a));
    for (std::size_t i = 0; i < 3; ++i) entries[3 * a + static_cast<PetscInt>(i)] = u[i];
  }
}

// (exp(theta) R_ref - I) S e_j + D e_j, column by column.
template <class T>
BodyMotion<T> RigidPart::motion_of_unknowns(std::span<const T> unknowns) const {
  BodyMotion<T> motion{motion_.rigid->centre, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) motion.translation[i] = T(given_translation_[i]);
  for (std::size_t k = 0; k < free_components_.size(); ++k) motion.translation[free_components_[k]] = unknowns[k];
  Vector3<T> theta{T(0.0), T(0.0), T(0.0)};
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const T angle = T(1.0 / (shape_.weight * size_)) * unknowns[free_components_.size() + k];
    for (std::size_t i = 0; i < 3; ++i) theta[i] = theta[i] + T(axes_[k][i]) * angle;
  }
  for (int j = 0; j < 3; ++j) {
    const Vector3<double> arm = {shape_.arms(0, j), shape_.arms(1, j), shape_.arms(2, j)};
    const Vector3<double> turned = turn(reference_, arm);
    const Vector3<T> x = turn(theta, Vector3<T>{T(turned[0]), T(turned[1]), T(turned[2])});
    for (int i = 0; i < 3; ++i) {
      motion.gradient(i, j) = x[static_cast<std::size_t>(i)] + T(shape_.drift(i, j) - shape_.arms(i, j));
    }
  }
  return motion;
}

// d exp(theta) / d theta_k x = (J_l(theta) e_k) x exp(theta) x: the left Jacobian of rotations.
PartMotion RigidPart::motion(std::span<const double> unknowns) const {
  PartMotion result{motion_of_unknowns(unknowns), {}, {}};
  const Vector3<double>& centre = motion_.rigid->centre;
  for (const std::size_t i : free_components_) {
    result.columns.push_back({centre, {}, {}});
    result.columns.back().translation[i] = 1.0;
  }
  const Tensor3<double> rotated = result.value.gradient - shape_.drift + shape_.arms;  // exp(theta) R_ref S
  const Vector3<double> theta = rotation_vector(unknowns);
  for (const auto& axis : axes_) {
    const Vector3<double> rate = (1.0 / (shape_.weight * size_)) * right_jacobian(-1.0 * theta, axis);
    result.columns.push_back({centre, {}, cross_columns(rate, rotated)});
  }
  if (is_symmetric()) {
    result.test_columns = result.columns;
    return result;
  }
  for (std::size_t k = 0; k < unknowns.size(); ++k) result.test_columns.push_back(virtual_motion(k, result.value));
  return result;
}

BodyMotion<double> RigidPart::virtual_motion(std::size_t k, const BodyMotion<double>& at) const {
  BodyMotion<double> result{at.centre, {}, {}};
  if (k < free_components_.size()) {
    result.translation[free_components_[k]] = 1.0;
  } else {
    result.gradient =
        cross_columns((1.0 / size_) * axes_[k - free_components_.size()], add_to_diagonal(at.gradient, 1.0));
  }
  return result;
}

std::vector<BodyMotion<double>> RigidPart::bends(std::span<const double> unknowns,
                                                 std::span<const BodyMotion<double>> columns) const {
  std::vector<BodyMotion<double>> result;
  const std::size_t num_free = free_components_.size(), n = unknowns.size();
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t l = 0; l < n; ++l) {
      BodyMotion<double>& bend = result.emplace_back(BodyMotion<double>{motion_.rigid->centre, {}, {}});
      if (k < num_free || l < num_free) continue;
      if (is_symmetric()) {
        bend = second_derivative(unknowns, k, l);
      } else {
        bend.gradient = cross_columns((1.0 / size_) * axes_[k - num_free], columns[l].gradient);
      }
    }
  }
  return result;
}

BodyMotion<double> RigidPart::second_derivative(std::span<const double> unknowns, std::size_t k, std::size_t l) const {
  using Once = Dual<double>;
  using Twice = Dual<Once>;
  std::vector<Twice> moved;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    moved.push_back({Once(unknowns[i], i == l ? 1.0 : 0.0), Once(i == k ? 1.0 : 0.0, 0.0)});
  }
  const auto motion = motion_of_unknowns(std::span<const Twice>(moved));
  BodyMotion<double> result{motion.centre, {}, {}};
  for (std::size_t i = 0; i < 9; ++i) result.gradient.a[i] = motion.gradient.a[i].slope.slope;
  return result;
}

MotionForce RigidPart::force_on_motion(std::span<const double> forces) const {
  MotionForce result;
  for (const PetscInt a : nodes_) {
    const auto first = 3 * static_cast<std::size_t>(a);
    const Vector3<double> force = {forces[first], forces[first + 1], forces[first + 2]};
    result.add(1.0, {force, outer(force, arm(a))});
  }
  return result;
}

const PartMotion& RigidPart::at(std::span<const double> unknowns) const {
  if (at_.columns.empty() || !std::ranges::equal(at_unknowns_, unknowns)) {
    at_unknowns_.assign(unknowns.begin(), unknowns.end());
    at_ = motion(unknowns);
  }
  return at_;
}

void RigidPart::put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const {
  const PartMotion& motion = at(unknowns);
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = motion.columns[k].displacement(reference(node));
}

void RigidPart::put_test_columns(std::span<const double> unknowns, PetscInt node,
                                 std::span<Vector3<double>> columns) const {
  const PartMotion& motion = at(unknowns);
  for (std::size_t k = 0; k < columns.size(); ++k) columns[k] = motion.test_columns[k].displacement(reference(node));
}

std::vector<double> RigidPart::curvature(std::span<const double> unknowns, Vec f) const {
  const ConstArrayView forces(f);
  const MotionForce force = force_on_motion(forces.span());
  std::vector<double> result;
  for (const auto& bend : bends(unknowns, at(unknowns).columns)) result.push_back(force.along(bend));
  return result;
}

void RigidPart::subtract_given(Vec v) const {
  const Vector3<double> centre = (*fit_)(*layout_, nodes_, v).translation;
  const ArrayView entries(v);
  for (std::size_t i = 0; i < 3; ++i) {
    if (!motion_.gives(static_cast<int>(i))) continue;
    for (const PetscInt a : nodes_) entries[3 * a + static_cast<PetscInt>(i)] -= centre[i];
  }
}

BodyMotion<double> RigidPart::motion_of(Vec u) const {
  const AffineMotion fitted = (*fit_)(*layout_, nodes_, u);
  return {motion_.rigid->centre, fitted.translation, fitted.gradient};
}

BodyMotion<double> RigidPart::RigidState::motion() const {
  const Placement rotated{{}, at.rotation};
  const auto column = [&](int j) {
    return rotated.displacement({j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0});
  };
  const std::array<Vector3<double>, 3> columns{column(0), column(1), column(2)};
  return {centre, at.translation,
          make_tensor([&](int i, int j) { return columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]; })};
}

BodyMotion<double> RigidPart::RigidState::rate() const {
  const Tensor3<double> R = rotation_matrix(at.rotation);
  return {centre, velocity, make_tensor([&](int i, int j) {
            return cross(omega, {R(0, j), R(1, j), R(2, j)})[static_cast<std::size_t>(i)];
          })};
}

RigidPart::RigidState RigidPart::state(const Step& step, Side side, Vec q, Vec v) const {
  return nearest_state({motion_, step.time, step.dt, 1.0, side}, q, v);
}

RigidPart::RigidState RigidPart::state(Vec q, Vec v) const {
  RigidState state{nearest(q), {}, {}, motion_.rigid->centre};
  const auto velocities = nearest_velocities(state.at, v);
  state.velocity = velocities[0];
  state.omega = velocities[1];
  return state;
}

RigidPart::RigidState RigidPart::moved(RigidState state, std::span<const double> unknowns,
                                       std::span<const double> rates) const {
  Vector3<double> theta{};
  for (std::size_t k = 0; k < free_components_.size(); ++k) {
    state.at.translation[free_components_[k]] += unknowns[k];
    state.velocity[free_components_[k]] += rates[k];
  }
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    theta = theta + (unknowns[free_components_.size() + k] / size_) * axes_[k];
    state.omega = state.omega + (rates[free_components_.size() + k] / size_) * axes_[k];
  }
  state.at.rotation = product(exponential(theta), state.at.rotation);
  return state;
}

void RigidPart::put(const RigidState& state, Vec q, Vec v) const {
  const ArrayView velocities(v);
  for (const PetscInt a : nodes_) {
    const auto w = state.velocity + cross(state.omega, turn(state.at.rotation, arm(a)));
    for (std::size_t i = 0; i < 3; ++i) velocities[3 * a + static_cast<PetscInt>(i)] = w[i];
  }
  if (q == nullptr) return;
  const ArrayView displacements(q);
  for (const PetscInt a : nodes_) {
    const auto u = state.at.displacement(arm(a));
    for (std::size_t i = 0; i < 3; ++i) displacements[3 * a + static_cast<PetscInt>(i)] = u[i];
  }
}

RigidPart::RigidState RigidPart::nearest_state(const GivenKinematics& given, Vec q, Vec v) const {
  RigidState state{nearest(q), {}, {}, motion_.rigid->centre};
  const auto velocities = nearest_velocities(state.at, v);
  state.velocity = velocities[0];
  state.omega = velocities[1];
  for (std::size_t i = 0; i < 3; ++i) {
    if (!motion_.gives(static_cast<int>(i))) continue;
    const Kinematics centre = given(static_cast<int>(i), motion_.rigid->centre);
    state.at.translation[i] = centre.u;
    state.velocity[i] = centre.v;
  }
  return state;
}

void RigidPart::restart(const Step& step, Vec q, Vec v) const {
  const RigidState state = nearest_state({motion_, step.time, step.dt, 1.0, Side::after}, q, v);
  const ArrayView velocities(v);
  for (const PetscInt a : nodes_) {
    const auto w = state.velocity + cross(state.omega, turn(state.at.rotation, arm(a)));
    for (std::size_t i = 0; i < 3; ++i) velocities[3 * a + static_cast<PetscInt>(i)] = w[i];
  }
}

void RigidPart::complete_step(const Step& step, Vec q, Vec v) const {
  const RigidState state = nearest_state({motion_, step.time, step.dt}, q, v);
  const ArrayView displacements(q), velocities(v);
  double deviation = 0.0;
  for (const PetscInt a : nodes_) {
    const auto u = state.at.displacement(arm(a));
    for (std::size_t i = 0; i < 3; ++i) {
      deviation = std::max(deviation, std::abs(u[i] - displacements[3 * a + static_cast<PetscInt>(i)]));
    }
  }
  const bool is_rigid = maximum(layout_->comm, deviation) <= rigidity_tolerance * size_;
  for (const PetscInt a : nodes_) {
    const auto u = state.at.displacement(arm(a)),
               w = state.velocity + cross(state.omega, turn(state.at.rotation, arm(a)));
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_rigid) displacements[3 * a + static_cast<PetscInt>(i)] = u[i];
      velocities[3 * a + static_cast<PetscInt>(i)] = w[i];
    }
  }
}

}  // namespace pliant
