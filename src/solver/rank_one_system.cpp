#include "solver/rank_one_system.hpp"

#include "solver/merit.hpp"

#include <cmath>
#include <limits>

namespace pliant {
RankOneSystem::RankOneSystem(KSP ksp, Mat K, const std::vector<RankOne>& parts) : K_(K), parts_(parts) {
  PetscInt size = 0;
  check(MatGetLocalSize(K, &size, nullptr));
  MPI_Comm comm = PetscObjectComm(reinterpret_cast<PetscObject>(K));
  check(MatCreateShell(comm, size, size, PETSC_DETERMINE, PETSC_DETERMINE, this, A_.out()));
  check(MatShellSetOperation(A_.get(), MATOP_MULT, reinterpret_cast<void (*)()>(multiply_callback)));
  PC pc = nullptr;
  check(KSPGetPC(ksp, &pc));
  check(PetscObjectReference(reinterpret_cast<PetscObject>(pc)));
  inner_ = Handle<PC>(pc);
  Handle<PC> outer;
  check(PCCreate(comm, outer.out()));
  check(PCSetType(outer.get(), PCSHELL));
  check(PCShellSetContext(outer.get(), this));
  check(PCShellSetApply(outer.get(), apply_callback));
  check(PCShellSetName(outer.get(), "rank-one terms, by Woodbury's formula"));
  check(PCShellSetView(outer.get(), view_callback));
  check(KSPSetPC(ksp, outer.get()));
  check(KSPSetOperators(ksp, A_.get(), K));
}

bool RankOneSystem::set_up(const std::function<void(Vec)>& clear) {
  directions_.clear();
  solutions_.clear();
  for (const RankOne& part : parts_) {
    Handle<Vec> direction, solution;
    check(VecDuplicate(part.g.get(), direction.out()));
    check(VecDuplicate(part.g.get(), solution.out()));
    check(VecCopy(part.g.get(), direction.get()));
    check(VecScale(direction.get(), std::sqrt(part.c)));
    if (clear) clear(direction.get());
    check(PCApply(inner_.get(), direction.get(), solution.get()));
    directions_.push_back(std::move(direction));
    solutions_.push_back(std::move(solution));
  }
  // T = L U; its pivots have the signs of its eigenvalues where it is symmetric.
  const std::size_t n = parts_.size();
  factors_.assign(n * n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      factors_[i * n + j] = (i == j ? 1.0 : 0.0) + dot(directions_[i].get(), solutions_[j].get());
    }
  }
  negative_ = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const double pivot = factors_[k * n + k];
    if (!(std::abs(pivot) > std::numeric_limits<double>::min())) return false;  // NaN too
    negative_ += pivot < 0.0 ? 1 : 0;
    for (std::size_t i = k + 1; i < n; ++i) {
      factors_[i * n + k] /= pivot;
      for (std::size_t j = k + 1; j < n; ++j) factors_[i * n + j] -= factors_[i * n + k] * factors_[k * n + j];
    }
  }
  return true;
}

void RankOneSystem::multiply(Vec x, Vec y) const {
  check(MatMult(K_, x, y));
  for (const RankOne& part : parts_) check(VecAXPY(y, part.c * dot(part.g.get(), x), part.g.get()));
}

void RankOneSystem::apply(Vec x, Vec y) const {
  check(PCApply(inner_.get(), x, y));
  // D G^T P x = (for a symmetric P) D Z^T x
  const std::size_t n = directions_.size();
  std::vector<double> t(n);
  for (std::size_t k = 0; k < n; ++k) t[k] = dot(directions_[k].get(), y);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) t[i] -= factors_[i * n + j] * t[j];
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t j = i + 1; j < n; ++j) t[i] -= factors_[i * n + j] * t[j];
    t[i] /= factors_[i * n + i];
  }
  for (std::size_t k = 0; k < n; ++k) check(VecAXPY(y, -t[k], solutions_[k].get()));
}

PetscErrorCode RankOneSystem::multiply_callback(Mat A, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = MatShellGetContext(A, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<RankOneSystem*>(self)->multiply(x, y); });
}

PetscErrorCode RankOneSystem::apply_callback(PC pc, Vec x, Vec y) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return CallbackGuard().run([&] { static_cast<RankOneSystem*>(self)->apply(x, y); });
}

PetscErrorCode RankOneSystem::view_callback(PC pc, PetscViewer viewer) {
  void* self = nullptr;
  const PetscErrorCode code = PCShellGetContext(pc, &self);
  if (code != 0) return code;
  return PCView(static_cast<RankOneSystem*>(self)->inner_.get(), viewer);
}

}  // namespace pliant
