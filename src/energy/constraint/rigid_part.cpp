#include "energy/constraint/rigid_part.hpp"

#include "energy/rigid/rigid_fit.hpp"
#include "material/spectral.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// Nodes closer to one line than this fraction of their size do not determine a rotation about it.
constexpr double collinearity = 1e-6;
/// Relative to the size: displacements that are rigid to this tolerance are left unchanged, which keeps their digits.
constexpr double rigidity_tolerance = 1e-13;

/// A dual vector: x and its derivative along b.
template <class T>
Vector3<Dual<T>> along(const Vector3<T>& x, const Vector3<double>& b) {
  return {Dual<T>(x[0], T(b[0])), Dual<T>(x[1], T(b[1])), Dual<T>(x[2], T(b[2]))};
}

template <class T>
Vector3<T> constant(const Vector3<double>& x) {
  return {T(x[0]), T(x[1]), T(x[2])};
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

void RigidPart::start_stage(const StagePoint& stage) const {
  if (rigidity_ != Rigidity::of_accelerations || free_components_.size() == 3) return;
  const double passed = stage.time - stage.step_start, dt = stage.dt;
  const GivenKinematics given(motion_, stage.time, passed > 0.0 ? passed : dt, stage.load_factor,
                              passed > 0.0 ? Side::before : Side::after);
  const Vector3<double> q0 = (*fit_)(*layout_, nodes_, stage.q0).translation;
  const Vector3<double> v0 = (*fit_)(*layout_, nodes_, stage.v0).translation;
  const ArrayView q(stage.q0), v(stage.v0);
  for (std::size_t i = 0; i < 3; ++i) {
    if (!motion_.gives(static_cast<int>(i))) continue;
    const Kinematics centre = given(static_cast<int>(i), motion_.rigid->centre);
    for (const PetscInt a : nodes_) {
      const PetscInt entry = 3 * a + static_cast<PetscInt>(i);
      q[entry] += centre.u - dt * centre.v - q0[i];
      v[entry] += centre.v - dt * centre.a - v0[i];
    }
  }
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
}

void RigidPart::begin_stage(const StagePoint& stage, Vec q) {
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& component = motion_.rigid->translation[i];
    given_translation_[i] = component ? stage.load_factor * (*component)(0.0, 0.0, 0.0, stage.time) : 0.0;
  }
  shape_ = shape_of(stage);
  reference_ = nearest_rotation((*fit_)(*layout_, nodes_, q).gradient);
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

void RigidPart::put_columns(std::span<const double> unknowns, PetscInt node, std::span<Vector3<double>> columns) const {
  const std::size_t num_free = free_components_.size();
  std::ranges::fill(columns, Vector3<double>{});
  for (std::size_t k = 0; k < num_free; ++k) columns[k][free_components_[k]] = 1.0;
  const Vector3<double> theta = rotation_vector(unknowns);
  const Vector3<double> s = turn(reference_, matvec(shape_.arms, arm(node)));
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const auto x = turn(along(theta, axes_[k]), constant<Dual<double>>(s));
    columns[num_free + k] = (1.0 / (shape_.weight * size_)) * Vector3<double>{x[0].slope, x[1].slope, x[2].slope};
  }
}

void RigidPart::put_test_columns(std::span<const double> unknowns, PetscInt node,
                                 std::span<Vector3<double>> columns) const {
  put_columns(unknowns, node, columns);
  if (is_symmetric()) return;
  const Placement rotated{{}, placement(unknowns).rotation};
  const Vector3<double> r = arm(node);
  const Vector3<double> Fr = r + matvec(shape_.drift, r) + rotated.displacement(matvec(shape_.arms, r));
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    columns[free_components_.size() + k] = (1.0 / size_) * cross(axes_[k], Fr);
  }
}

std::vector<double> RigidPart::curvature(std::span<const double> unknowns, Vec f) const {
  const Vector3<double> theta = rotation_vector(unknowns);
  const std::size_t num_free = free_components_.size(), n = hosts_.size();
  std::vector<double> result(n * n, 0.0);
  const ConstArrayView forces(f);
  for (const PetscInt a : nodes_) {
    const Vector3<double> force = {forces[3 * a], forces[3 * a + 1], forces[3 * a + 2]};
    const Vector3<double> s = turn(reference_, matvec(shape_.arms, arm(a)));
    std::array<Vector3<double>, most_unknowns> columns{};
    put_columns(unknowns, a, std::span(columns).first(n));
    for (std::size_t k = 0; k < axes_.size(); ++k) {
      for (std::size_t l = 0; l < axes_.size(); ++l) {
        double& entry = result[n * (num_free + k) + num_free + l];
        if (is_symmetric()) {
          const auto twice = turn(along(along(theta, axes_[k]), axes_[l]), constant<Dual<Dual<double>>>(s));
          for (std::size_t i = 0; i < 3; ++i) entry += force[i] * twice[i].slope.slope / (size_ * size_);
        } else {
          entry += dot(force, cross(axes_[k], columns[num_free + l])) / size_;
        }
      }
    }
  }
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
