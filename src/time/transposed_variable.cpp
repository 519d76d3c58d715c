#include "time/transposed_variable.hpp"

#include <cassert>

namespace pliant {

TransposedVariable::TransposedVariable(std::size_t num_stages, Vec like) : stages_(num_stages) {
  check(VecDuplicate(like, base_.out()));
  for (Handle<Vec>& stage : stages_) check(VecDuplicate(like, stage.out()));
}

void TransposedVariable::begin(const Method& method, Vec end) {
  assert(method.bt.size() <= stages_.size());
  double rest = 1.0;
  for (std::size_t i = 0; i < method.bt.size(); ++i) {
    check(VecCopy(end, stages_[i].get()));
    check(VecScale(stages_[i].get(), method.bt[i]));
    rest -= method.bt[i];
  }
  check(VecCopy(end, base_.get()));
  check(VecScale(base_.get(), method.stiffly_accurate ? 0.0 : rest));
}

void TransposedVariable::start_stage(const Method& method, std::size_t i, Vec start) {
  double rest = 1.0;
  for (std::size_t j = 0; j < i; ++j) {
    check(VecAXPY(stages_[j].get(), method.At[i][j], start));
    rest -= method.At[i][j];
  }
  check(VecAXPY(base_.get(), rest, start));
}

}  // namespace pliant
