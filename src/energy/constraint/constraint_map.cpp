#include "energy/constraint/constraint_map.hpp"

#include "energy/constraint/sparse_rows.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/matrix_parts.hpp"

#include <algorithm>

namespace pliant {
namespace {

void assemble(Mat matrix) {
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
}

}  // namespace

ConstraintMap::ConstraintMap(const NodeLayout& layout, std::span<const Slave> slaves,
                             std::vector<GivenDisplacement> given,
                             std::vector<std::unique_ptr<DependentNodes>> dependents)
    : comm_(layout.comm),
      first_entry_(3 * layout.first_global_node),
      num_owned_(3 * layout.num_owned_nodes),
      has_ties_(!slaves.empty()),
      ties_(layout, slaves, std::move(given)),
      dependents_(std::move(dependents)),
      is_slave_(static_cast<std::size_t>(num_owned_), 0),
      is_tied_(is_slave_) {
  SparseRows rows(static_cast<std::size_t>(num_owned_));
  for (PetscInt i = 0; i < num_owned_; ++i) rows[i][first_entry_ + i] = 1.0;
  const auto mark_slave = [&](PetscInt i) {
    rows[i] = {{first_entry_ + i, 0.0}};
    is_slave_[i] = is_tied_[i] = 1;
  };
  for (const Slave& slave : slaves) {
    for (const auto& master : slave.masters) {
      if (owns(master.entry)) is_tied_[master.entry - first_entry_] = 1;
    }
    if (!owns(slave.entry)) continue;
    const PetscInt i = slave.entry - first_entry_;
    mark_slave(i);
    for (const auto& [entry, coefficient] : slave.masters) rows[i][entry] = coefficient;
  }
  for (const auto& dependent : dependents_) {
    for (const PetscInt a : dependent->nodes()) {
      for (PetscInt i = 3 * a; i < 3 * a + 3; ++i) {
        mark_slave(i);
        for (const PetscInt host : dependent->hosts()) rows[i][host] = 0.0;
      }
    }
  }
  for (const auto& dependent : dependents_) {
    for (const PetscInt host : dependent->hosts()) {
      if (owns(host)) is_slave_[host - first_entry_] = 0;
    }
  }
  J_ = make_sparse_matrix(comm_, rows);
  W_ = J_.share();
  find_places();
}

void ConstraintMap::find_places() {
  const MatrixRows own(J_.get(), 0), others(J_.get(), 1);
  for (const auto& dependent : dependents_) {
    auto& places = places_.emplace_back();
    for (const PetscInt a : dependent->nodes()) {
      for (PetscInt row = 3 * a; row < 3 * a + 3; ++row) {
        for (const PetscInt host : dependent->hosts()) places.push_back((owns(host) ? own : others).entry(row, host));
      }
    }
  }
}

Handle<Vec> ConstraintMap::make_vector() const {
  Handle<Vec> result;
  check(MatCreateVecs(J_.get(), nullptr, result.out()));
  return result;
}

void ConstraintMap::set_rigidity(Rigidity rigidity) {
  linearized_at_.clear();
  for (const auto& dependent : dependents_) dependent->set_rigidity(rigidity);
  W_ = J_.share();
  if (std::ranges::all_of(dependents_, [](const auto& dependent) { return dependent->is_symmetric(); })) return;
  W_ = Handle<Mat>();
  check(MatDuplicate(J_.get(), MAT_COPY_VALUES, W_.out()));
}

PetscInt64 ConstraintMap::num_unsymmetric() const {
  PetscInt64 number = 0;
  for (const auto& dependent : dependents_) {
    if (!dependent->is_symmetric()) number += static_cast<PetscInt64>(dependent->hosts().size());
  }
  return number;
}

std::vector<PetscInt> ConstraintMap::unsymmetric_unknowns() const {
  std::vector<PetscInt> result;
  for (const auto& dependent : dependents_) {
    if (dependent->is_symmetric()) continue;
    const auto hosts = dependent->hosts();
    result.insert(result.end(), hosts.begin(), hosts.end());
  }
  std::ranges::sort(result);
  return result;
}

std::vector<std::string> ConstraintMap::non_potentials() const {
  std::vector<std::string> result;
  for (const auto& dependent : dependents_) {
    if (dependent->is_symmetric()) continue;
    const std::string description = dependent->description();
    if (std::ranges::find(result, description) == result.end()) result.push_back(description);
  }
  return result;
}

std::vector<double> ConstraintMap::unknowns_of(const DependentNodes& dependent, Vec y) const {
  const auto hosts = dependent.hosts();
  std::vector<double> result(hosts.size(), 0.0);
  {
    const ConstArrayView entries(y);
    for (std::size_t k = 0; k < hosts.size(); ++k) {
      if (owns(hosts[k])) result[k] = entries[hosts[k] - first_entry_];
    }
  }
  sum_in_place(comm_, result);
  return result;
}

void ConstraintMap::put_unknowns(const DependentNodes& dependent, std::span<const double> unknowns, Vec y) const {
  const auto hosts = dependent.hosts();
  const ArrayView entries(y);
  for (std::size_t k = 0; k < hosts.size(); ++k) {
    if (owns(hosts[k])) entries[hosts[k] - first_entry_] = unknowns[k];
  }
}

void ConstraintMap::begin_stage(const StagePoint& stage, Vec q) {
  linearized_at_.clear();
  ties_.begin_stage(stage, q);
  for (const auto& dependent : dependents_) dependent->begin_stage(stage, q);
}

void ConstraintMap::set_prescribed_fraction(double fraction) {
  linearized_at_.clear();
  ties_.set_prescribed_fraction(fraction);
  for (const auto& dependent : dependents_) dependent->set_prescribed_fraction(fraction);
}

void ConstraintMap::expand(Vec y, Vec q) const {
  check(VecCopy(y, q));
  ties_.put_slaves(y, q);
  for (const auto& dependent : dependents_) dependent->put_displacements(unknowns_of(*dependent, y), q);
}

void ConstraintMap::put_rows(Mat matrix, std::size_t dependent, std::span<const double> unknowns,
                             PutColumns put) const {
  const auto& nodes = *dependents_[dependent];
  const auto hosts = nodes.hosts();
  std::vector<Vector3<double>> columns(hosts.size());
  const MatrixValues values(matrix);
  auto place = places_[dependent].begin();
  for (const PetscInt a : nodes.nodes()) {
    (nodes.*put)(unknowns, a, columns);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < hosts.size(); ++k) values[owns(hosts[k]) ? 0 : 1][*place++] = columns[k][i];
    }
  }
}

void ConstraintMap::linearize(Vec y) {
  if (is_linear()) return;
  std::vector<std::vector<double>> unknowns_of_all;
  for (const auto& dependent : dependents_) unknowns_of_all.push_back(unknowns_of(*dependent, y));
  if (linearized_at_ == unknowns_of_all) return;
  linearized_at_ = std::move(unknowns_of_all);
  for (std::size_t d = 0; d < dependents_.size(); ++d) {
    put_rows(J_.get(), d, linearized_at_[d], &DependentNodes::put_columns);
    if (!is_symmetric()) put_rows(W_.get(), d, linearized_at_[d], &DependentNodes::put_test_columns);
  }
  assemble(J_.get());
  if (!is_symmetric()) assemble(W_.get());
}

void ConstraintMap::begin_end_of_step(Vec q) {
  linearized_at_.clear();
  for (const auto& dependent : dependents_) dependent->begin_end_of_step(q);
}

void ConstraintMap::linearize_at(Vec q) {
  begin_end_of_step(q);
  for (std::size_t d = 0; d < dependents_.size(); ++d) {
    const std::vector<double> at_reference(dependents_[d]->hosts().size(), 0.0);
    put_rows(J_.get(), d, at_reference, &DependentNodes::put_columns);
  }
  assemble(J_.get());
}

void ConstraintMap::keep_free_motion_of_dependents(Vec v) const {
  std::vector<char> is_kept(is_slave_.size(), 0);
  for (const auto& dependent : dependents_) {
    for (const PetscInt a : dependent->nodes()) std::fill_n(is_kept.begin() + 3 * a, 3, 1);
  }
  {
    const ArrayView entries(v);
    for (PetscInt i = 0; i < num_owned_; ++i) {
      if (!is_kept[i]) entries[i] = 0.0;
    }
  }
  for (const auto& dependent : dependents_) dependent->subtract_given(v);
}

void ConstraintMap::clear_dependents(Vec v) const {
  const ArrayView entries(v);
  for (const auto& dependent : dependents_) {
    for (const PetscInt a : dependent->nodes()) std::fill_n(entries.span().begin() + 3 * a, 3, 0.0);
  }
}

void ConstraintMap::add_curvature(Vec y, Vec f, Mat K, const std::function<PetscInt(PetscInt)>& place) const {
  if (is_linear()) return;
  PetscInt first = 0, last = 0;
  check(MatGetOwnershipRange(K, &first, &last));
  for (const auto& dependent : dependents_) {
    auto values = dependent->curvature(unknowns_of(*dependent, y), f);
    sum_in_place(comm_, values);
    std::vector<PetscInt> places;
    for (const PetscInt host : dependent->hosts()) places.push_back(place(host));
    const auto n = static_cast<PetscInt>(places.size());
    for (PetscInt k = 0; k < n; ++k) {
      const PetscInt row = places[static_cast<std::size_t>(k)];
      if (row < first || row >= last) continue;  // another rank's
      check(MatSetValues(K, 1, &row, n, places.data(), values.data() + n * k, ADD_VALUES));
    }
  }
  assemble(K);
}

std::vector<char> ConstraintMap::is_ideal() const {
  std::vector<char> result(is_slave_.size(), 0);
  for (const auto& dependent : dependents_) {
    if (!dependent->is_ideal()) continue;
    for (const PetscInt a : dependent->nodes()) std::fill_n(result.begin() + 3 * a, 3, 1);
  }
  return result;
}

bool ConstraintMap::is_driven() const {
  return std::ranges::any_of(dependents_, [](const auto& dependent) { return dependent->is_driven(); });
}

bool ConstraintMap::refreezes() const {
  return std::ranges::any_of(dependents_, [](const auto& dependent) { return dependent->refreezes(); });
}

void ConstraintMap::refreeze(Vec y, Vec r) {
  for (const auto& dependent : dependents_) {
    if (dependent->refreezes()) dependent->refreeze(unknowns_of(*dependent, y), r);
  }
}

double ConstraintMap::rotation(Vec y) const {
  double largest = 0.0;
  for (const auto& dependent : dependents_) {
    largest = std::max(largest, dependent->rotation(unknowns_of(*dependent, y)));
  }
  return largest;
}

double ConstraintMap::rotation_by(Vec step, Vec y) const {
  double largest = 0.0;
  for (const auto& dependent : dependents_) {
    largest = std::max(largest, dependent->rotation_by(unknowns_of(*dependent, step), unknowns_of(*dependent, y)));
  }
  return largest;
}

void ConstraintMap::restrict(Vec q, Vec y) const {
  check(VecCopy(q, y));
  for (const auto& dependent : dependents_) put_unknowns(*dependent, dependent->nearest_unknowns(q), y);
}

void ConstraintMap::restrict_rates(Vec v, Vec w) const {
  check(VecCopy(v, w));
  for (const auto& dependent : dependents_) put_unknowns(*dependent, dependent->nearest_rates(v), w);
}

PrescribedMotion ConstraintMap::motion(PrescribedMotion before, Correction correction) const {
  PrescribedMotion motion;
  motion.start_stage = [this, correction, start = std::move(before.start_stage)](const StagePoint& stage, Vec q) {
    start(stage, q);
    ties_.start_stage(stage, q, correction);
    for (const auto& dependent : dependents_) dependent->start_stage(stage);
  };
  motion.complete_step = [this, correction, complete = std::move(before.complete_step)](const Step& step, Vec q,
                                                                                        Vec v) {
    complete(step, q, v);
    ties_.complete_step(step, q, v, correction);
    for (const auto& dependent : dependents_) dependent->complete_step(step, q, v);
  };
  motion.restart = [this, restart = std::move(before.restart)](const Step& step, Vec q, Vec v) {
    restart(step, q, v);
    ties_.restart(step, v);
    for (const auto& dependent : dependents_) dependent->restart(step, q, v);
  };
  return motion;
}

}  // namespace pliant
