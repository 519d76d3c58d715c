#include "time/stage_variable.hpp"

#include <cassert>

namespace pliant {

StageVariable::StageVariable(const Method& method, Vec layout) {
  for (Handle<Vec>* x : {&base_, &stage_}) check(VecDuplicate(layout, x->out()));
  if (method.stiffly_accurate) {
    end_ = stage_.share();
  } else {
    check(VecDuplicate(layout, end_.out()));
  }
  increments_.resize(static_cast<std::size_t>(method.num_stages - (method.stiffly_accurate ? 1 : 0)));
  for (Handle<Vec>& x : increments_) {
    check(VecDuplicate(layout, x.out()));
    borrowed_.push_back(x.get());
  }
  if (increments_.empty()) {
    start_ = base_.share();
  } else {
    check(VecDuplicate(layout, start_.out()));
  }
}

void StageVariable::set_base(std::span<const Vec> past, std::span<const double> alpha) {
  assert(!alpha.empty() && past.size() >= alpha.size());
  check(VecCopy(past[0], base_.get()));
  for (std::size_t r = 1; r < alpha.size(); ++r) {
    check(VecWAXPY(stage_.get(), -1.0, past[0], past[r]));
    check(VecAXPY(base_.get(), alpha[r], stage_.get()));
  }
}

void StageVariable::start_stage(std::span<const double> At_i) {
  if (start_.get() != base_.get()) check(VecCopy(base_.get(), start_.get()));
  if (At_i.empty()) return;
  check(VecMAXPY(start_.get(), static_cast<PetscInt>(At_i.size()), At_i.data(), borrowed_.data()));
}

void StageVariable::end_stage(std::size_t i) {
  if (i < increments_.size()) check(VecWAXPY(borrowed_[i], -1.0, base_.get(), stage_.get()));
}

void StageVariable::start_last_stage(std::span<const double> bt) {
  if (end_.get() == stage_.get()) return;
  check(VecCopy(base_.get(), end_.get()));
  check(VecScale(end_.get(), 1.0 - bt.back()));
  check(VecMAXPY(end_.get(), static_cast<PetscInt>(bt.size()) - 1, bt.data(), borrowed_.data()));
}

void StageVariable::complete_step(std::span<const double> bt) {
  if (end_.get() == stage_.get()) return;
  check(VecCopy(base_.get(), end_.get()));
  check(VecMAXPY(end_.get(), static_cast<PetscInt>(bt.size()), bt.data(), borrowed_.data()));
}

void StageVariable::combine_increments(std::span<const double> d, Vec x) const {
  const std::size_t num_kept = increments_.size();
  check(VecZeroEntries(x));
  if (num_kept < d.size()) {  // the last one is not kept
    check(VecWAXPY(x, -1.0, base_.get(), stage_.get()));
    check(VecScale(x, d.back()));
  }
  if (num_kept > 0) check(VecMAXPY(x, static_cast<PetscInt>(num_kept), d.data(), const_cast<Vec*>(borrowed_.data())));
}

}  // namespace pliant
