#include "energy/constraint/constraint_map.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {

ConstraintMap::ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves,
                             std::vector<GivenDisplacement> given, std::vector<RigidPatch> patches)
    : comm_(layout.comm),
      first_entry_(3 * layout.first_global_node),
      given_(std::move(given)),
      patches_(std::move(patches)) {
  const PetscInt num_owned = 3 * layout.num_owned_nodes;
  const auto is_owned = [&](PetscInt entry) { return entry >= first_entry_ && entry < first_entry_ + num_owned; };
  is_slave_.assign(static_cast<std::size_t>(num_owned), 0);
  is_tied_ = is_slave_;
  Rows rows(static_cast<std::size_t>(num_owned));
  for (PetscInt i = 0; i < num_owned; ++i) rows[i][first_entry_ + i] = 1.0;
  std::vector<double> squares;  // of the coefficients of each owned slave's constraint
  for (const Slave& slave : slaves) {
    for (const auto& master : slave.masters) {
      if (is_owned(master.entry)) is_tied_[master.entry - first_entry_] = 1;
    }
    if (!is_owned(slave.entry)) continue;
    const PetscInt i = slave.entry - first_entry_;
    is_slave_[i] = is_tied_[i] = 1;
    rows[i][slave.entry] = 0.0;
    double sum = 1.0;
    for (const auto& [entry, coefficient] : slave.masters) {
      rows[i][entry] = coefficient;
      sum += coefficient * coefficient;
    }
    squares.push_back(sum);
    slaves_.push_back({i, slave.given});
  }
  C_ = make_matrix(rows);
  Rows sizes = rows;
  for (auto& row : sizes) {
    for (auto& [entry, coefficient] : row) coefficient = std::abs(coefficient);
  }
  sizes_ = make_matrix(sizes);
  J_ = patches_.empty() ? C_.share() : make_jacobian(std::move(rows));
  W_ = J_.share();
  for (Handle<Vec>* x : {&offset_, &start_offset_, &end_offset_, &work_, &missing_, &forces_, &direction_, &image_,
                         &inverse_diagonal_}) {
    *x = make_vector(layout);
  }
  const ArrayView inverse(inverse_diagonal_.get());
  for (std::size_t s = 0; s < slaves_.size(); ++s) inverse[slaves_[s].local_entry] = 1.0 / squares[s];
}

Handle<Mat> ConstraintMap::make_matrix(const Rows& rows) const {
  std::vector<PetscInt> offsets{0}, columns;
  std::vector<double> values;
  for (const auto& row : rows) {
    for (const auto& [column, value] : row) {
      columns.push_back(column);
      values.push_back(value);
    }
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  const auto num_owned = static_cast<PetscInt>(rows.size());
  Handle<Mat> matrix;
  check(MatCreate(comm_, matrix.out()));
  check(MatSetSizes(matrix.get(), num_owned, num_owned, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(matrix.get(), MATMPIAIJ));
  check(MatSetBlockSize(matrix.get(), 3));
  check(MatMPIAIJSetPreallocationCSR(matrix.get(), offsets.data(), columns.data(), values.data()));
  return matrix;
}

// `rows`: those of C.
Handle<Mat> ConstraintMap::make_jacobian(Rows rows) {
  for (const RigidPatch& patch : patches_) {
    for (const PetscInt a : patch.nodes()) {
      for (PetscInt i = 3 * a; i < 3 * a + 3; ++i) {
        rows[i] = {{first_entry_ + i, 0.0}};
        for (const PetscInt host : patch.hosts()) rows[i][host] = 0.0;
        is_tied_[i] = is_slave_[i] = 1;
      }
    }
    for (const PetscInt host : patch.hosts()) {
      const PetscInt i = host - first_entry_;
      if (i >= 0 && i < static_cast<PetscInt>(rows.size())) is_slave_[i] = 0;
    }
  }
  return make_matrix(rows);
}

void ConstraintMap::set_rigidity(Rigidity rigidity) {
  for (RigidPatch& patch : patches_) patch.set_rigidity(rigidity);
  if (is_linear() || rigidity == Rigidity::of_configurations) {
    W_ = J_.share();
  } else {
    W_ = Handle<Mat>();
    check(MatDuplicate(J_.get(), MAT_COPY_VALUES, W_.out()));
  }
}

void ConstraintMap::begin_stage(const StagePoint& stage, Vec q) {
  for (RigidPatch& patch : patches_) patch.begin_stage(stage, q);
  if (stage.accepted != nullptr) check(MatMult(C_.get(), stage.accepted, work_.get()));
  {
    const ConstArrayView accepted(stage.accepted != nullptr ? stage.accepted : q), followed(work_.get());
    const ArrayView start(start_offset_.get()), end(end_offset_.get());
    for (const auto& slave : slaves_) {
      double u = 0.0;
      for (const GivenTerm& g : slave.given) {
        u += g.weight * given_[g.source](g.component, g.X, stage.time, stage.load_factor);
      }
      end[slave.local_entry] = u;
      start[slave.local_entry] =
          stage.accepted != nullptr ? accepted[slave.local_entry] - followed[slave.local_entry] : u;
    }
  }
  set_prescribed_fraction(1.0);
}

void ConstraintMap::set_prescribed_fraction(double fraction) {
  check(VecCopy(end_offset_.get(), offset_.get()));
  if (fraction != 1.0) check(VecAXPBY(offset_.get(), 1.0 - fraction, fraction, start_offset_.get()));
}

void ConstraintMap::expand(Vec y, Vec q) const {
  check(MatMultAdd(C_.get(), y, offset_.get(), q));
  for (const RigidPatch& patch : patches_) patch.put_displacements(patch.unknowns(y), q);
}

void ConstraintMap::put_columns(Mat matrix, const RigidPatch& patch, PetscInt node,
                                const RigidPatch::Columns& columns) const {
  for (std::size_t i = 0; i < 3; ++i) {
    std::array<double, RigidPatch::most_unknowns> values{};
    for (std::size_t k = 0; k < columns.size(); ++k) values[k] = columns[k][i];
    const PetscInt row = first_entry_ + 3 * node + static_cast<PetscInt>(i);
    check(MatSetValues(matrix, 1, &row, static_cast<PetscInt>(patch.hosts().size()), patch.hosts().data(),
                       values.data(), INSERT_VALUES));
  }
}

void ConstraintMap::linearize(Vec y) {
  if (is_linear()) return;
  for (const RigidPatch& patch : patches_) {
    const auto unknowns = patch.unknowns(y);
    for (const PetscInt a : patch.nodes()) {
      put_columns(J_.get(), patch, a, patch.columns(unknowns, a));
      if (!is_symmetric()) put_columns(W_.get(), patch, a, patch.test_columns(unknowns, a));
    }
  }
  for (Mat matrix : {J_.get(), W_.get()}) {
    check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  }
}

void ConstraintMap::linearize_at(Vec q) {
  for (RigidPatch& patch : patches_) {
    patch.linearize_at(q);
    const std::vector<double> at_reference(patch.hosts().size(), 0.0);
    for (const PetscInt a : patch.nodes()) put_columns(J_.get(), patch, a, patch.columns(at_reference, a));
  }
  check(MatAssemblyBegin(J_.get(), MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(J_.get(), MAT_FINAL_ASSEMBLY));
}

void ConstraintMap::keep_free_patches(Vec v) const {
  std::vector<char> is_kept(is_slave_.size(), 0);
  for (const RigidPatch& patch : patches_) {
    for (const PetscInt a : patch.nodes()) std::fill_n(is_kept.begin() + 3 * a, 3, 1);
  }
  {
    const ArrayView entries(v);
    for (std::size_t i = 0; i < is_kept.size(); ++i) {
      if (!is_kept[i]) entries[static_cast<PetscInt>(i)] = 0.0;
    }
  }
  for (const RigidPatch& patch : patches_) patch.subtract_given(v);
}

void ConstraintMap::add_curvature(Vec y, Vec f, Mat K, const std::function<PetscInt(PetscInt)>& place) const {
  if (is_linear()) return;
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(K, &first, &last));
  for (const RigidPatch& patch : patches_) {
    const auto values = patch.curvature(patch.unknowns(y), f);
    std::vector<PetscInt> places;
    for (const PetscInt host : patch.hosts()) places.push_back(place(host));
    const auto n = static_cast<PetscInt>(places.size());
    for (PetscInt k = 0; k < n; ++k) {
      const PetscInt row = places[static_cast<std::size_t>(k)];
      if (row < first || row >= last) continue;  // another rank's
      check(MatSetValues(K, 1, &row, n, places.data(), values.data() + n * k, ADD_VALUES));
    }
  }
  check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
}

void ConstraintMap::restrict(Vec q, Vec y) const {
  check(VecCopy(q, y));
  for (const RigidPatch& patch : patches_) patch.put_unknowns(patch.nearest_unknowns(q), y);
}

void ConstraintMap::restrict_rates(Vec v, Vec w) const {
  check(VecCopy(v, w));
  for (const RigidPatch& patch : patches_) patch.put_unknowns(patch.nearest_rates(v), w);
}

std::vector<Kinematics> ConstraintMap::offsets(double time, double time_scale, double factor, Side side) const {
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

void ConstraintMap::constrain(Vec x, Vec y) const {
  check(MatMult(C_.get(), x, work_.get()));
  check(VecZeroEntries(y));
  const ConstArrayView entries(x), followed(work_.get());
  const ArrayView result(y);
  for (const auto& slave : slaves_) {
    result[slave.local_entry] = entries[slave.local_entry] - followed[slave.local_entry];
  }
}

void ConstraintMap::weigh_slaves(Vec q, Vec x) const {
  check(VecCopy(q, work_.get()));
  check(VecAbs(work_.get()));
  check(MatMult(sizes_.get(), work_.get(), x));
  check(VecCopy(inverse_diagonal_.get(), work_.get()));  // 1 / (1 + sum C_sm^2)
  const ArrayView to(x), inverse(work_.get());
  for (PetscInt i = 0; i < static_cast<PetscInt>(to.span().size()); ++i) {
    to[i] *= inverse[i] > 0.0 ? std::sqrt(1.0 / inverse[i] - 1.0) : 0.0;
  }
}

void ConstraintMap::add_constraint_forces(Vec m, Vec x) const {
  check(MatMultTranspose(C_.get(), m, work_.get()));
  check(VecAXPY(x, -1.0, work_.get()));
  check(VecAXPY(x, 1.0, m));
}

template <class Offset>
void ConstraintMap::follow(Vec x, Offset offset) const {
  check(MatMult(C_.get(), x, work_.get()));
  const ConstArrayView followed(work_.get());
  const ArrayView entries(x);
  for (std::size_t s = 0; s < slaves_.size(); ++s) {
    entries[slaves_[s].local_entry] = followed[slaves_[s].local_entry] + offset(s);
  }
}

// x += G^T m, G G^T m = offset - G x, by conjugate gradients preconditioned by the diagonal: constraints share few
// entries, so that a few iterations suffice.
template <class Offset>
void ConstraintMap::put_nearest(Vec x, Offset offset) const {
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
  // NaN stays NaN, and is detected elsewhere.
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

PrescribedMotion ConstraintMap::motion(PrescribedMotion before, Mending mending) const {
  const auto mend = [this, mending](Vec x, const auto& offset) {
    mending == Mending::nearest ? put_nearest(x, offset) : follow(x, offset);
  };
  PrescribedMotion motion;
  motion.start_stage = [this, mend, start = std::move(before.start_stage)](const StagePoint& stage, Vec q) {
    start(stage, q);
    // The time before the step may lie behind a kink.
    const double passed = stage.time - stage.step_start, dt = stage.dt;
    const auto g =
        offsets(stage.time, passed > 0.0 ? passed : dt, stage.load_factor, passed > 0.0 ? Side::before : Side::after);
    mend(q, [&](std::size_t s) { return g[s].u; });
    mend(stage.q0, [&](std::size_t s) { return g[s].u - dt * g[s].v; });
    mend(stage.v0, [&](std::size_t s) { return g[s].v - dt * g[s].a; });
    for (const RigidPatch& patch : patches_) patch.start_stage(stage);
  };
  motion.complete_step = [this, mend, complete = std::move(before.complete_step)](const Step& step, Vec q, Vec v) {
    complete(step, q, v);
    const auto g = offsets(step.time, step.dt, 1.0);
    mend(q, [&](std::size_t s) { return g[s].u; });
    mend(v, [&](std::size_t s) { return g[s].v; });
    for (const RigidPatch& patch : patches_) patch.make_rigid(step.time, step.dt, q, v);
  };
  motion.restart = [this, restart = std::move(before.restart)](const Step& step, Vec q, Vec v) {
    restart(step, q, v);
    const auto g = offsets(step.time, step.dt, 1.0, Side::after);
    put_nearest(v, [&](std::size_t s) { return g[s].v; });
    for (const RigidPatch& patch : patches_) patch.make_velocities_rigid(step.time, step.dt, q, v);
  };
  return motion;
}

std::vector<std::array<double, 3>> ConstraintMap::multipliers(Vec reaction) const {
  std::vector<std::array<double, 3>> result(given_.size(), std::array<double, 3>{});
  const ConstArrayView r(reaction);
  for (const auto& slave : slaves_) {
    for (const GivenTerm& g : slave.given) {
      result[g.source][static_cast<std::size_t>(g.component)] += g.weight * r[slave.local_entry];
    }
  }
  return result;
}

}  // namespace pliant
