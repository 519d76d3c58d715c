#include "energy/constraint/linear_ties.hpp"

#include "energy/constraint/sparse_rows.hpp"
#include "petsc/array_view.hpp"

#include <cmath>

namespace pliant {

LinearTies::LinearTies(const NodeLayout& layout, std::span<const Slave> slaves, std::vector<GivenDisplacement> given)
    : is_empty_(slaves.empty()), given_(std::move(given)) {
  const PetscInt first = 3 * layout.first_global_node, num_owned = 3 * layout.num_owned_nodes;
  SparseRows rows(static_cast<std::size_t>(num_owned)), sizes(rows);
  std::vector<double> squares;  // of the coefficients of each owned slave's tie
  for (const Slave& slave : slaves) {
    const PetscInt i = slave.entry - first;
    if (i < 0 || i >= num_owned) continue;
    double sum = 1.0;
    for (const auto& [entry, coefficient] : slave.masters) {
      rows[i][entry] = coefficient;
      sizes[i][entry] = std::abs(coefficient);
      sum += coefficient * coefficient;
    }
    squares.push_back(sum);
    slaves_.push_back({i, slave.given});
  }
  C_ = make_sparse_matrix(layout.comm, rows);
  sizes_ = make_sparse_matrix(layout.comm, sizes);
  for (Handle<Vec>* x : {&offset_, &start_offset_, &end_offset_, &work_, &missing_, &forces_, &direction_, &image_,
                         &inverse_diagonal_}) {
    *x = make_vector(layout);
  }
  const ArrayView inverse(inverse_diagonal_.get());
  for (std::size_t s = 0; s < slaves_.size(); ++s) inverse[slaves_[s].local_entry] = 1.0 / squares[s];
}

void LinearTies::begin_stage(const StagePoint& stage, Vec q) {
  if (stage.accepted != nullptr) check(MatMult(C_.get(), stage.accepted, work_.get()));
  const auto given = offsets(stage);
  {
    const ConstArrayView accepted(stage.accepted != nullptr ? stage.accepted : q), followed(work_.get());
    const ArrayView start(start_offset_.get()), end(end_offset_.get());
    for (std::size_t s = 0; s < slaves_.size(); ++s) {
      const PetscInt entry = slaves_[s].local_entry;
      end[entry] = given[s].u;
      start[entry] = stage.accepted != nullptr ? accepted[entry] - followed[entry] : given[s].u;
    }
  }
  set_prescribed_fraction(1.0);
}

void LinearTies::set_prescribed_fraction(double fraction) {
  check(VecCopy(end_offset_.get(), offset_.get()));
  if (fraction != 1.0) check(VecAXPBY(offset_.get(), 1.0 - fraction, fraction, start_offset_.get()));
}

void LinearTies::put_slaves(Vec y, Vec q) const {
  if (is_empty_) return;
  check(MatMultAdd(C_.get(), y, offset_.get(), work_.get()));
  const ConstArrayView followed(work_.get());
  const ArrayView entries(q);
  for (const auto& slave : slaves_) entries[slave.local_entry] = followed[slave.local_entry];
}

std::vector<Kinematics> LinearTies::offsets(double time, double time_scale, double factor, Side side) const {
  std::vector<GivenKinematics> given;
  for (const GivenDisplacement& g : given_) given.emplace_back(g, time, time_scale, factor, side);
  std::vector<Kinematics> result;
  for (const auto& slave : slaves_) {
    Kinematics& sum = result.emplace_back();
    for (const GivenTerm& g : slave.given) {
      const Kinematics k = given[g.source](g.component, g.X);
      sum.u += g.weight * k.u;
      sum.v += g.weight * k.v;
      sum.a += g.weight * k.a;
    }
  }
  return result;
}

std::vector<Kinematics> LinearTies::offsets(const StagePoint& stage) const {
  // The time before the step may lie behind a kink.
  const double passed = stage.time - stage.step_start;
  return passed > 0.0 ? offsets(stage.time, passed, stage.load_factor, Side::before)
                      : offsets(stage.time, stage.dt, stage.load_factor, Side::after);
}

void LinearTies::constrain(Vec x, Vec y) const {
  check(MatMult(C_.get(), x, work_.get()));
  check(VecZeroEntries(y));
  const ConstArrayView entries(x), followed(work_.get());
  const ArrayView result(y);
  for (const auto& slave : slaves_) {
    result[slave.local_entry] = entries[slave.local_entry] - followed[slave.local_entry];
  }
}

void LinearTies::add_constraint_forces(Vec m, Vec x) const {
  check(MatMultTranspose(C_.get(), m, work_.get()));
  check(VecAXPY(x, -1.0, work_.get()));
  check(VecAXPY(x, 1.0, m));
}

void LinearTies::follow(Vec x, const Offsets& offset) const {
  check(MatMult(C_.get(), x, work_.get()));
  const ConstArrayView followed(work_.get());
  const ArrayView entries(x);
  for (std::size_t s = 0; s < slaves_.size(); ++s) {
    entries[slaves_[s].local_entry] = followed[slaves_[s].local_entry] + offset(s);
  }
}

// x += G^T m, G G^T m = offset - G x, by conjugate gradients preconditioned by the diagonal: constraints share few
// entries, so that a few iterations suffice.
void LinearTies::put_nearest(Vec x, const Offsets& offset) const {
  constexpr double rounding = 1e-14;
  constexpr int most_iterations = 200;
  const Vec r = missing_.get(), z = forces_.get(), d = direction_.get(), image = image_.get();
  PetscReal largest = 0.0, wrong = 0.0, size = 0.0;
  const auto preconditioned_size = [&] {
    check(VecPointwiseMult(z, inverse_diagonal_.get(), r));
    PetscScalar product = 0.0;
    check(VecDot(r, z, &product));
    return product;
  };
  constrain(x, r);
  check(VecScale(r, -1.0));
  {
    const ArrayView missing(r);
    for (std::size_t s = 0; s < slaves_.size(); ++s) missing[slaves_[s].local_entry] += offset(s);
  }
  check(VecNorm(r, NORM_INFINITY, &wrong));
  check(VecNorm(x, NORM_INFINITY, &largest));
  // NaN remains NaN, and is detected elsewhere.
  if (wrong > rounding * largest && std::isfinite(wrong)) {
    double rho = preconditioned_size();
    const double first = rho;
    check(VecCopy(z, d));
    for (int i = 0; i < most_iterations && rho > rounding * rounding * first; ++i) {
      // Add G^T d to the entries, subtract G G^T d from the violation.
      check(VecZeroEntries(image));
      add_constraint_forces(d, image);
      check(VecNorm(image, NORM_2, &size));
      const double alpha = rho / (size * size);
      check(VecAXPY(x, alpha, image));
      constrain(image, z);
      check(VecAXPY(r, -alpha, z));
      const double before = rho;
      rho = preconditioned_size();
      check(VecAYPX(d, rho / before, z));
    }
  }
  follow(x, offset);  // exact to the last digit
}

void LinearTies::correct(Vec x, const Offsets& offset, Correction correction) const {
  if (is_empty_) return;
  correction == Correction::nearest ? put_nearest(x, offset) : follow(x, offset);
}

void LinearTies::start_stage(const StagePoint& stage, Vec q, Correction correction) const {
  const double dt = stage.dt;
  const auto g = offsets(stage);
  correct(
      q, [&](std::size_t s) { return g[s].u; }, correction);
  correct(
      stage.q0, [&](std::size_t s) { return g[s].u - dt * g[s].v; }, correction);
  correct(
      stage.v0, [&](std::size_t s) { return g[s].v - dt * g[s].a; }, correction);
}

void LinearTies::complete_step(const Step& step, Vec q, Vec v, Correction correction) const {
  const auto g = offsets(step.time, step.dt, 1.0);
  correct(
      q, [&](std::size_t s) { return g[s].u; }, correction);
  correct(
      v, [&](std::size_t s) { return g[s].v; }, correction);
}

void LinearTies::restart(const Step& step, Vec v) const {
  const auto g = offsets(step.time, step.dt, 1.0, Side::after);
  correct(
      v, [&](std::size_t s) { return g[s].v; }, Correction::nearest);
}

void LinearTies::weigh_slaves(Vec q, Vec x) const {
  check(VecCopy(q, work_.get()));
  check(VecAbs(work_.get()));
  check(MatMult(sizes_.get(), work_.get(), x));
  check(VecCopy(inverse_diagonal_.get(), work_.get()));  // 1 / (1 + sum C_sm^2)
  const ArrayView to(x), inverse(work_.get());
  for (PetscInt i = 0; i < static_cast<PetscInt>(to.span().size()); ++i) {
    to[i] *= inverse[i] > 0.0 ? std::sqrt(1.0 / inverse[i] - 1.0) : 0.0;
  }
}

std::vector<std::array<double, 3>> LinearTies::multipliers(Vec reaction) const {
  std::vector<std::array<double, 3>> result(given_.size(), std::array<double, 3>{});
  for_each_given(reaction, [&](const GivenTerm& term, double force) {
    result[term.source][static_cast<std::size_t>(term.component)] += force;
  });
  return result;
}

}  // namespace pliant
