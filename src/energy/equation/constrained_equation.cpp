#include "energy/equation/constrained_equation.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace pliant {
namespace {

/// Unknowns of the equation to one whose row is unsymmetric, at least, for the whole to count as nearly symmetric.
constexpr PetscInt64 many_to_one = 10;
/// The most unknowns whose rows are treated apart, by dense matrices.
constexpr PetscInt64 largest_border = 300;

}  // namespace

ConstrainedEquation::ConstrainedEquation(StageEquation& equation, ConstraintMap& map)
    : equation_(equation),
      map_(map),
      jacobian_(map.jacobian(), equation.make_vector().get()),
      full_(equation.make_hessian()),
      y_part_(map.make_vector().get()),
      x_part_(map.make_vector().get()) {
  for (Handle<Vec>* x : {&x_, &d_, &full_gradient_, &y0_, &w0_, &accepted_, &start_}) *x = equation.make_vector();
  for (KnownGradient& known : known_) {
    known.y = equation.make_vector();
    known.r = equation.make_vector();
  }
  if (!map.is_symmetric()) own_test_matrix_.emplace(map.test_matrix(), x_.get());
  make_product();
  PetscInt size = 0;
  check(VecGetLocalSize(x_.get(), &size));
  prescribed_.assign(equation.prescribed().begin(), equation.prescribed().begin() + size);
  for (std::size_t i = 0; i < map.is_slave().size(); ++i) {
    if (map.is_slave()[i]) prescribed_[i] = 1;
  }
  symmetry_ = find_symmetry();
}

Symmetry ConstrainedEquation::find_symmetry() const {
  const Symmetry symmetry = equation_.symmetry();
  const bool is_nearly = symmetry == Symmetry::nearly_symmetric;
  if (map_.is_symmetric()) return is_nearly ? Symmetry::unsymmetric : symmetry;
  if (symmetry != Symmetry::symmetric && !is_nearly) return Symmetry::unsymmetric;
  const auto num_free = static_cast<PetscInt64>(std::ranges::count(prescribed_, char{0}));
  const bool are_few = many_to_one * map_.num_unsymmetric() <= sum(comm(), num_free);
  return are_few ? Symmetry::nearly_symmetric : Symmetry::unsymmetric;
}

std::vector<PetscInt> ConstrainedEquation::border() const {
  if (symmetry_ != Symmetry::nearly_symmetric || map_.num_unsymmetric() > largest_border) return {};
  std::vector<PetscInt> rows;
  for (const PetscInt unknown : map_.unsymmetric_unknowns()) rows.push_back(jacobian_.place(unknown));
  return rows;
}

void ConstrainedEquation::forget_gradients() {
  for (KnownGradient& known : known_) known.is_known = false;
}

Vec ConstrainedEquation::gradient_in_x(Vec y) {
  for (const std::size_t k : {last_known_, 1 - last_known_}) {
    PetscBool is_there = PETSC_FALSE;
    if (known_[k].is_known) check(VecEqual(y, known_[k].y.get(), &is_there));
    if (is_there == PETSC_FALSE) continue;
    last_known_ = k;
    return known_[k].r.get();
  }
  last_known_ = 1 - last_known_;
  KnownGradient& known = known_[last_known_];
  expand(y, x_.get());
  equation_.gradient(x_.get(), known.r.get());
  check(VecCopy(y, known.y.get()));
  known.is_known = true;
  return known.r.get();
}

void ConstrainedEquation::give_up() {
  forget_gradients();
  equation_.give_up();
}

void ConstrainedEquation::forget() {
  forget_gradients();
  equation_.forget();
}

void ConstrainedEquation::set_prescribed_fraction(double fraction) {
  if (fraction == fraction_) return;
  forget_gradients();
  fraction_ = fraction;
  map_.set_prescribed_fraction(fraction);
}

void ConstrainedEquation::expand(Vec y, Vec x) const {
  check(VecCopy(y, x));
  const LeadingPart::Of from(y_part_, y), to(x_part_, x);
  map_.expand(from.get(), to.get());
}

void ConstrainedEquation::restrict(Vec x, Vec y) const {
  check(VecCopy(x, y));
  const LeadingPart::Of from(x_part_, x), to(y_part_, y);
  map_.restrict(from.get(), to.get());
}

void ConstrainedEquation::restrict_rates(Vec x, Vec y) const {
  check(VecCopy(x, y));
  const LeadingPart::Of from(x_part_, x), to(y_part_, y);
  map_.restrict_rates(from.get(), to.get());
}

void ConstrainedEquation::linearize(Vec y) {
  if (map_.is_linear()) return;
  {
    const LeadingPart::Of part(y_part_, y);
    map_.linearize(part.get());
  }
  jacobian_.update();
  if (own_test_matrix_) own_test_matrix_->update();
}

StagePoint ConstrainedEquation::enter(const StagePoint& stage, Vec q, Vec y) {
  forget_gradients();
  fraction_ = 1.0;
  map_.begin_stage(stage, q);
  const StagePoint whole = equation_.enter(stage, q, x_.get());
  check(VecCopy(x_.get(), start_.get()));
  restrict(x_.get(), y);
  if (map_.is_linear()) return whole;
  check(VecWAXPY(x_.get(), stage.dt, whole.v0, whole.q0));
  restrict(x_.get(), y0_.get());
  check(VecZeroEntries(w0_.get()));
  StagePoint reduced = whole;
  reduced.q0 = y0_.get();
  reduced.v0 = w0_.get();
  if (whole.accepted != nullptr) {
    set_prescribed_fraction(0.0);
    restrict(whole.accepted, accepted_.get());
    set_prescribed_fraction(1.0);
    reduced.accepted = accepted_.get();
  }
  return reduced;
}

void ConstrainedEquation::leave(Vec y, Vec q) {
  expand(y, x_.get());
  equation_.leave(x_.get(), q);
}

double ConstrainedEquation::value(Vec y) {
  expand(y, x_.get());
  return equation_.value(x_.get());
}

void ConstrainedEquation::gradient(Vec y, Vec r) {
  Vec in_x = gradient_in_x(y);
  linearize(y);
  check(MatMultTranspose(test_matrix(), in_x, r));
}

Handle<Mat> ConstrainedEquation::make_hessian() const {
  Handle<Mat> K = product_->make();
  const PetscBool is_symmetric = pliant::is_symmetric(symmetry()) ? PETSC_TRUE : PETSC_FALSE;
  check(MatSetOption(K.get(), MAT_SYMMETRIC, is_symmetric));
  check(MatSetOption(K.get(), MAT_SYMMETRY_ETERNAL, is_symmetric));
  check(MatSetOption(K.get(), MAT_STRUCTURALLY_SYMMETRIC, PETSC_TRUE));
  set_near_null_space(K.get());
  return K;
}

// The modes of the body in the unknowns. Slaves follow; a mode that the constraints forbid still has a low energy.
void ConstrainedEquation::set_near_null_space(Mat K) const {
  MatNullSpace space = nullptr;
  check(MatGetNearNullSpace(full_.get(), &space));
  if (space == nullptr) return;
  PetscInt num_modes = 0;
  const Vec* modes = nullptr;
  check(MatNullSpaceGetVecs(space, nullptr, &num_modes, &modes));
  std::vector<Handle<Vec>> reduced;
  for (PetscInt m = 0; m < num_modes; ++m) {
    Handle<Vec> mode;
    check(VecDuplicate(modes[m], mode.out()));
    restrict_rates(modes[m], mode.get());
    {
      const ArrayView entries(mode.get());
      for (std::size_t i = 0; i < map_.is_slave().size(); ++i) {
        if (map_.is_slave()[i]) entries[static_cast<PetscInt>(i)] = 0.0;
      }
    }
    reduced.push_back(std::move(mode));
  }
  set_near_null_modes(K, std::move(reduced));
}

void ConstrainedEquation::follow_rigid_motions(Vec y, Mat K) const {
  expand(y, x_.get());
  equation_.follow_rigid_motions(x_.get(), full_.get());
  set_near_null_space(K);
}

std::unique_ptr<NodalRotations> ConstrainedEquation::make_rotations() const {
  auto rotations = equation_.make_rotations();
  if (rotations) rotations->hold(map_.is_tied());
  return rotations;
}

void ConstrainedEquation::refreeze_map(Vec y, Vec r) {
  {
    const LeadingPart::Of unknowns(y_part_, y);
    if (r == nullptr) {
      map_.refreeze(unknowns.get(), nullptr);
    } else {
      const LeadingPart::Of forces(x_part_, r);
      map_.refreeze(unknowns.get(), forces.get());
    }
  }
  forget_gradients();
}

// A guess is not in equilibrium, and inertia may exert forces of any size on constraints there: the first solution is
// without what follows from them. Without inertia they may be too large, and what sticks in the first solution may
// slide in the next one; what slides in the first one would come to rest far from where it sticks.
void ConstrainedEquation::freeze(Vec y) {
  forget_gradients();
  if (map_.refreezes()) refreeze_map(y, nullptr);
  expand(y, x_.get());
  equation_.freeze(x_.get());
  if (map_.refreezes() && is_static()) refreeze_map(y, gradient_in_x(y));
}

bool ConstrainedEquation::refreeze(Vec y) {
  forget_gradients();
  expand(y, x_.get());
  const bool refreezes = equation_.refreeze(x_.get());
  if (map_.refreezes()) refreeze_map(y, gradient_in_x(y));
  return refreezes;
}

void ConstrainedEquation::exceed_bound() {
  forget_gradients();
  equation_.exceed_bound();
}

void ConstrainedEquation::drag(Vec y, Vec at, Vec f) {
  forget_gradients();
  if (map_.refreezes()) {
    expand(at, x_.get());
    equation_.drag(x_.get(), x_.get(), full_gradient_.get());  // freezes the terms there
    refreeze_map(at, gradient_in_x(at));
  }
  expand(at, d_.get());
  expand(y, x_.get());
  equation_.drag(x_.get(), d_.get(), full_gradient_.get());
  linearize(y);
  check(MatMultTranspose(test_matrix(), full_gradient_.get(), f));
}

bool ConstrainedEquation::follow_obstacles(Followers which, Vec y) {
  if (!equation_.follow_obstacles(which, x_.get())) return false;
  restrict(x_.get(), y);
  return true;
}

bool ConstrainedEquation::follow_prescribed_nodes(Vec y) {
  expand(y, x_.get());
  if (!equation_.follow_prescribed_nodes(x_.get())) return false;
  restrict(x_.get(), y);
  return true;
}

bool ConstrainedEquation::is_far_from_guess(Vec y) {
  constexpr double far = 1.0;
  if (!is_static()) return false;
  const LeadingPart::Of at(y_part_, y);
  return map_.rotation(at.get()) > far;
}

Vec ConstrainedEquation::displacements(Vec y) {
  expand(y, x_.get());
  return equation_.displacements(x_.get());
}

void ConstrainedEquation::make_product() {
  pattern_of_full_ = pattern_id(full_.get());
  std::vector<RowsOfColumns> dense;
  for (const auto& dependent : map_.dependents()) {
    RowsOfColumns& of = dense.emplace_back();
    for (const PetscInt a : dependent->nodes()) of.rows.insert(of.rows.end(), {3 * a, 3 * a + 1, 3 * a + 2});
    for (const PetscInt host : dependent->hosts()) of.columns.push_back(jacobian_.place(host));
  }
  product_.emplace(full_.get(), test_matrix(), jacobian_.matrix(), map_.is_tied(), map_.is_slave(), std::move(dense));
}

void ConstrainedEquation::project(Mat K) {
  if (pattern_id(full_.get()) != pattern_of_full_) {
    present_pattern_.change();
    make_product();
  }
  if (!present_pattern_.is_that_of(K)) present_pattern_.give(K, make_hessian());
  product_->set(full_.get(), K);
}

void ConstrainedEquation::hessian(Vec y, Mat K, Projection projection) {
  expand(y, x_.get());
  equation_.hessian(x_.get(), full_.get(), projection);
  linearize(y);
  project(K);
  if (map_.is_linear() || projection == Projection::positive_semidefinite) return;
  const LeadingPart::Of unknowns(y_part_, y), forces(x_part_, gradient_in_x(y));
  map_.add_curvature(unknowns.get(), forces.get(), K, [&](PetscInt entry) { return jacobian_.place(entry); });
}

void ConstrainedEquation::size_of_diagonal(Mat K, Vec D) const {
  equation_.size_of_diagonal(full_.get(), D);
  product_->put_diagonal(K, D);
}

std::vector<std::string> ConstrainedEquation::non_potentials() const {
  auto names = equation_.non_potentials();
  std::ranges::copy(map_.non_potentials(), std::back_inserter(names));
  return names;
}

void ConstrainedEquation::rank_one_parts(Vec y, std::vector<RankOne>& parts) {
  expand(y, x_.get());
  equation_.rank_one_parts(x_.get(), parts);
  linearize(y);
  // Instead of W^T g (J^T g)^T its symmetric neighbour: where W is not J, it is as near as the rotation in a stage is
  // small.
  for (const RankOne& part : parts) {
    check(VecCopy(part.g.get(), full_gradient_.get()));
    check(MatMultTranspose(test_matrix(), full_gradient_.get(), part.g.get()));
  }
}

void ConstrainedEquation::expand_direction(Vec y, Vec d) {
  expand(y, x_.get());
  linearize(y);
  check(MatMult(jacobian_.matrix(), d, d_.get()));
  if (fraction_ == 1.0) return;
  // With the rest of what is prescribed, which comes with this displacement.
  map_.set_prescribed_fraction(1.0);
  expand(y, full_gradient_.get());
  map_.set_prescribed_fraction(fraction_);
  check(VecAXPBYPCZ(d_.get(), 1.0, -1.0, 1.0, full_gradient_.get(), x_.get()));
}

// The further a body rotates, the less does the direction say; without inertia it may be of any length.
double ConstrainedEquation::max_step(Vec y, Vec d) {
  constexpr double longest_rotation = 1.0;
  expand_direction(y, d);
  const double bound = equation_.max_step(x_.get(), d_.get());
  if (!is_static()) return bound;
  const LeadingPart::Of at(y_part_, y), along(y_part_, d);
  const double rotation = map_.rotation_by(along.get(), at.get());
  return rotation > 0.0 ? std::min(bound, longest_rotation / rotation) : bound;
}

void ConstrainedEquation::extrapolate_from(Vec y) {
  forget_gradients();
  if (y != nullptr) expand(y, x_.get());
  equation_.extrapolate_from(y != nullptr ? x_.get() : nullptr);
}

double ConstrainedEquation::max_step_to_wall(Vec y, Vec d, Walls which) {
  expand_direction(y, d);
  return equation_.max_step_to_wall(x_.get(), d_.get(), which);
}

double ConstrainedEquation::force_scale(Vec y) {
  expand(y, x_.get());
  return equation_.force_scale(x_.get());
}

double ConstrainedEquation::rounding_floor(Vec y) const {
  expand(y, x_.get());
  const double of_entries = equation_.rounding_floor(x_.get());
  check(VecZeroEntries(d_.get()));
  {
    const LeadingPart::Of q(x_part_, x_.get()), slaves(y_part_, d_.get());
    map_.weigh_slaves(q.get(), slaves.get());
  }
  if (is_static()) {
    // A part that returns to its place is turned back: its displacements are differences of those at the start.
    const ConstArrayView start(start_.get());
    const ArrayView sizes(d_.get());
    for (const auto& part : map_.dependents()) {
      for (const PetscInt a : part->nodes()) {
        for (PetscInt i = 3 * a; i < 3 * a + 3; ++i) sizes[i] = std::max(sizes[i], std::abs(start[i]));
      }
    }
  }
  return std::hypot(of_entries, equation_.rounding_floor(d_.get()));
}

}  // namespace pliant
