#include "study/adjoint_pair.hpp"

#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "study/strained_mesh.hpp"

#include <cmath>
#include <utility>

namespace pliant {

std::vector<PetscInt> cells_of_internal(const IncrementalPotential& potential) {
  std::vector<PetscInt> cells;
  for (const EnergyTerm* term : potential.terms()) {
    const auto components = static_cast<std::size_t>(term->internal_components());
    std::vector<InternalPlace> places(term->num_internal() / components);
    term->place_internal(places);
    for (const InternalPlace& place : places) cells.insert(cells.end(), components, place.cell);
  }
  return cells;
}

AdjointPair::Side::Side(const Mesh& mesh, Config given, const NodeLayout& layout)
    : config(std::move(given)),
      model(mesh, config, layout),
      motion(analysis_of(config) == Analysis::static_equilibrium ? model.constraints().motion() : model.motion()),
      internal(model.potential().internal_variables()),
      z(model.potential().make_internal()) {
  for (Handle<Vec>* x : {&q, &v, &q0, &v0, &r}) *x = make_vector(model.layout());
}

AdjointPair::AdjointPair(const Mesh& mesh, const NodeLayout& layout, const AdjointParameter& parameter) {
  const double size = parameter.size > 0.0 ? parameter.size : std::abs(parameter.value);
  auto pair = neighbours_of(parameter.value, size, [&](double x) {
    if (!parameter.strain) return std::make_unique<Side>(mesh, parameter.make(x), layout);
    NodeLayout strained = layout;
    strain(*parameter.strain, x - 1.0, strained.coordinates);
    const StrainedMesh of_mesh(mesh, *parameter.strain, x - 1.0);
    return std::make_unique<Side>(mesh, parameter.make(x), strained);
  });
  below_ = std::move(pair.below);
  above_ = std::move(pair.above);
  spacing_ = pair.spacing;
  if (!parameter.by_cell) return;
  of_cells_.assign(static_cast<std::size_t>(below_->model.layout().num_local_cells), 0.0);
  internal_cells_ = cells_of_internal(below_->model.potential());
}

double AdjointPair::product(Handle<Vec> Side::*what, Vec b) const {
  Vec difference = ((*above_).*what).get();
  check(VecAXPY(difference, -1.0, ((*below_).*what).get()));
  PetscScalar result = 0.0;
  check(VecDot(difference, b, &result));
  return result;
}

void AdjointPair::clear(Handle<Vec> Side::*what) const {
  for (Side* side : {below_.get(), above_.get()}) check(VecZeroEntries((side->*what).get()));
}

void AdjointPair::add_stage(const RecordedStage& stage, const StageBars& bars) {
  std::vector<double> works(of_cells_.size());
  for (Side* side : {below_.get(), above_.get()}) {
    StagePoint point = stage.point;
    point.q0 = side->q0.get();
    point.v0 = side->v0.get();
    check(VecCopy(stage.q.get(), side->q.get()));
    check(VecCopy(stage.q0.get(), point.q0));
    check(VecCopy(stage.v0.get(), point.v0));
    side->motion.start_stage(point, side->q.get());
    IncrementalPotential& potential = side->model.potential();
    potential.begin_stage(point);
    potential.gradient(side->q.get(), side->r.get());
    if (!of_cells_.empty()) {
      for (double& work : works) work = -work;  // above - below
      potential.adjoint().add_cell_works(side->q.get(), bars.residual, works);
    }
    if (side->z) side->internal.end_stage(point, side->q.get(), side->z.get());
  }
  for (std::size_t c = 0; c < works.size(); ++c) of_cells_[c] += works[c];
  total_ += product(&Side::r, bars.residual) + product(&Side::q, bars.q) + product(&Side::q0, bars.q0);
  if (bars.internal != nullptr) add_internal(bars.internal);
}

void AdjointPair::add_internal(Vec bar) {
  total_ += product(&Side::z, bar);
  if (of_cells_.empty()) return;
  const ConstArrayView change(above_->z.get()), multipliers(bar);
  for (std::size_t i = 0; i < internal_cells_.size(); ++i) {
    of_cells_[static_cast<std::size_t>(internal_cells_[i])] += change.span()[i] * multipliers.span()[i];
  }
}

void AdjointPair::add_completion(Vec q, Vec internal) {
  if (internal == nullptr) return;
  clear(&Side::z);
  for (Side* side : {below_.get(), above_.get()}) {
    check(VecCopy(q, side->q.get()));
    side->internal.complete_step(nullptr, side->q.get(), side->z.get());
  }
  add_internal(internal);
}

void AdjointPair::add_end(const Step& step, Vec q, Vec v) {
  clear(&Side::q);
  clear(&Side::v);
  for (Side* side : {below_.get(), above_.get()}) side->motion.complete_step(step, side->q.get(), side->v.get());
  total_ += product(&Side::q, q) + product(&Side::v, v);
}

void AdjointPair::add_restart(const Step& step, Vec v) {
  clear(&Side::q);
  clear(&Side::v);
  for (Side* side : {below_.get(), above_.get()}) side->motion.restart(step, side->q.get(), side->v.get());
  total_ += product(&Side::v, v);
}

void AdjointPair::add_start(Vec q, Vec v) {
  for (Side* side : {below_.get(), above_.get()}) {
    side->model.set_initial_state(side->config, side->q.get(), side->v.get());
  }
  total_ += product(&Side::q, q) + product(&Side::v, v);
}

std::vector<double> AdjointPair::derivatives_of_cells() const {
  std::vector<double> result = of_cells_;
  for (double& d : result) d /= spacing_;
  return result;
}

double AdjointPair::part_not_of_cells() const {
  const NodeLayout& layout = below_->model.layout();
  std::vector<double> sums{0.0, 0.0};
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    sums[0] += of_cells_[static_cast<std::size_t>(c)];
    sums[1] += std::abs(of_cells_[static_cast<std::size_t>(c)]);
  }
  sum_in_place(layout.comm, sums);
  const double size = std::max(sums[1], std::abs(total_));
  return size > 0.0 ? std::abs(sums[0] - total_) / size : 0.0;
}

}  // namespace pliant
