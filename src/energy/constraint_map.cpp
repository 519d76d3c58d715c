#include "energy/constraint_map.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <map>

namespace pliant {

ConstraintMap::ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves,
                             std::vector<GivenDisplacement> given)
    : given_(std::move(given)) {
  const PetscInt num_owned = 3 * layout.num_owned_nodes, first = 3 * layout.first_global_node;
  const auto is_owned = [&](PetscInt entry) { return entry >= first && entry < first + num_owned; };
  is_slave_.assign(static_cast<std::size_t>(num_owned), 0);
  is_tied_ = is_slave_;
  std::vector<std::map<PetscInt, double>> rows(static_cast<std::size_t>(num_owned));
  for (PetscInt i = 0; i < num_owned; ++i) rows[i][first + i] = 1.0;
  for (const Slave& slave : slaves) {
    for (const auto& master : slave.masters) {
      if (is_owned(master.entry)) is_tied_[master.entry - first] = 1;
    }
    if (!is_owned(slave.entry)) continue;
    const PetscInt i = slave.entry - first;
    is_slave_[i] = is_tied_[i] = 1;
    rows[i][slave.entry] = 0.0;
    for (const auto& [entry, coefficient] : slave.masters) rows[i][entry] = coefficient;
    slaves_.push_back({i, slave.given});
  }

  std::vector<PetscInt> offsets{0}, columns;
  std::vector<double> values;
  for (const auto& row : rows) {
    for (const auto& [column, value] : row) {
      columns.push_back(column);
      values.push_back(value);
    }
    offsets.push_back(static_cast<PetscInt>(columns.size()));
  }
  check(MatCreate(layout.comm, C_.out()));
  check(MatSetSizes(C_.get(), num_owned, num_owned, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(C_.get(), MATMPIAIJ));
  check(MatSetBlockSize(C_.get(), 3));
  check(MatMPIAIJSetPreallocationCSR(C_.get(), offsets.data(), columns.data(), values.data()));
  offset_ = make_vector(layout);
  work_ = make_vector(layout);
}

void ConstraintMap::set_time(double time, double factor) {
  const ArrayView offset(offset_.get());
  for (const auto& slave : slaves_) {
    double u = 0.0;
    for (const GivenTerm& g : slave.given) u += g.weight * given_[g.source](g.component, g.X, time, factor);
    offset[slave.local_entry] = u;
  }
}

void ConstraintMap::expand(Vec y, Vec q) const {
  check(MatMultAdd(C_.get(), y, offset_.get(), q));
}

std::vector<Kinematics> ConstraintMap::offsets(double time, double time_scale, double factor) const {
  std::vector<GivenKinematics> given;
  for (const GivenDisplacement& g : given_) given.emplace_back(g, time, time_scale, factor);
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

template <class Offset>
void ConstraintMap::put_slaves(Vec x, Offset offset) const {
  check(MatMult(C_.get(), x, work_.get()));
  const ConstArrayView followed(work_.get());
  const ArrayView entries(x);
  for (std::size_t s = 0; s < slaves_.size(); ++s) {
    entries[slaves_[s].local_entry] = followed[slaves_[s].local_entry] + offset(s);
  }
}

PrescribedMotion ConstraintMap::motion(PrescribedMotion before) const {
  PrescribedMotion motion;
  motion.start_stage = [this, start = before.start_stage](const StagePoint& stage, Vec q) {
    start(stage, q);
    // What came before the step may lie behind a kink.
    const double passed = stage.time - stage.step_start, dt = stage.dt;
    const auto g = offsets(stage.time, passed > 0.0 ? passed : dt, stage.load_factor);
    put_slaves(q, [&](std::size_t s) { return g[s].u; });
    put_slaves(stage.q0, [&](std::size_t s) { return g[s].u - dt * g[s].v; });
    put_slaves(stage.v0, [&](std::size_t s) { return g[s].v - dt * g[s].a; });
  };
  motion.complete_step = [this, complete = before.complete_step](const Step& step, Vec q, Vec v) {
    complete(step, q, v);
    const auto g = offsets(step.time, step.dt, 1.0);
    put_slaves(q, [&](std::size_t s) { return g[s].u; });
    put_slaves(v, [&](std::size_t s) { return g[s].v; });
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
