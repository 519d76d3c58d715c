/// Equations of a few unknowns that all lie on rank 0, as those of one rigid body do; and a recorder of iterates.
#pragma once

#include "energy/stage_equation.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <cmath>
#include <functional>
#include <limits>

namespace pliant::test {

/// r(x) and K(x) (row major) of n unknowns, without a potential.
struct SmallFunction {
  PetscInt n = 0;
  std::function<std::vector<double>(std::span<const double>)> residual;
  std::function<std::vector<double>(std::span<const double>)> tangent;
};

class SmallEquation : public StageEquation {
 public:
  SmallEquation(MPI_Comm comm, SmallFunction function)
      : comm_(comm),
        function_(std::move(function)),
        local_size_(rank(comm) == 0 ? function_.n : 0),
        prescribed_(static_cast<std::size_t>(local_size_), 0) {}

  StagePoint enter(const StagePoint& stage, Vec q, Vec xi) override {
    check(VecCopy(q, xi));
    return stage;
  }
  double value(Vec) override { return 0.0; }
  void gradient(Vec q, Vec r) override {
    const ConstArrayView x(q);
    const ArrayView rows(r);  // on ranks without rows too: PETSc keeps norms until it hears that an array was written
    if (local_size_ == 0) return;
    std::ranges::copy(function_.residual(x.span()), rows.span().begin());
  }
  Handle<Mat> make_hessian() const override {
    Handle<Mat> K;
    check(MatCreateAIJ(comm_, local_size_, local_size_, PETSC_DETERMINE, PETSC_DETERMINE, function_.n, nullptr, 0,
                       nullptr, K.out()));
    return K;
  }
  void hessian(Vec q, Mat K, Projection) override {
    if (local_size_ > 0) {
      const ConstArrayView x(q);
      const auto values = function_.tangent(x.span());
      std::vector<PetscInt> all;
      for (PetscInt i = 0; i < local_size_; ++i) all.push_back(i);
      check(MatSetValues(K, local_size_, all.data(), local_size_, all.data(), values.data(), INSERT_VALUES));
    }
    check(MatAssemblyBegin(K, MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(K, MAT_FINAL_ASSEMBLY));
  }
  double max_step(Vec, Vec) override { return std::numeric_limits<double>::infinity(); }
  double force_scale(Vec) override { return 1.0; }
  double rounding_floor(Vec) const override { return 0.0; }
  std::vector<std::string> non_potentials() const override { return {"small"}; }
  Symmetry symmetry() const override { return Symmetry::unsymmetric; }
  const std::vector<char>& prescribed() const override { return prescribed_; }
  PetscInt num_unknowns() const override { return function_.n; }
  MPI_Comm comm() const override { return comm_; }
  Handle<Vec> make_vector() const override {
    Handle<Vec> v;
    check(VecCreateMPI(comm_, local_size_, PETSC_DETERMINE, v.out()));
    return v;
  }

  /// A vector with the same entry everywhere.
  Handle<Vec> filled(double value) const {
    Handle<Vec> v = make_vector();
    check(VecSet(v.get(), value));
    return v;
  }

 private:
  MPI_Comm comm_;
  SmallFunction function_;
  PetscInt local_size_;
  std::vector<char> prescribed_;
};

/// Another equation, with the norms of its residual at the iterates of Newton's method.
class Recorder final : public StageEquation {
 public:
  explicit Recorder(StageEquation& of) : of_(of), r_(of.make_vector()) {}
  const std::vector<double>& residuals() const { return residuals_; }

  StagePoint enter(const StagePoint& stage, Vec q, Vec xi) override { return of_.enter(stage, q, xi); }
  void leave(Vec xi, Vec q) override { of_.leave(xi, q); }
  double value(Vec q) override { return of_.value(q); }
  void gradient(Vec q, Vec r) override { of_.gradient(q, r); }
  Handle<Mat> make_hessian() const override { return of_.make_hessian(); }
  void hessian(Vec q, Mat K, Projection projection) override {
    of_.gradient(q, r_.get());
    PetscReal size = 0.0;
    check(VecNorm(r_.get(), NORM_2, &size));
    if (projection == Projection::none) residuals_.push_back(size);
    of_.hessian(q, K, projection);
  }
  double max_step(Vec q, Vec d) override { return of_.max_step(q, d); }
  double force_scale(Vec q) override { return of_.force_scale(q); }
  double rounding_floor(Vec q) const override { return of_.rounding_floor(q); }
  std::vector<std::string> non_potentials() const override { return of_.non_potentials(); }
  Symmetry symmetry() const override { return of_.symmetry(); }
  const std::vector<char>& prescribed() const override { return of_.prescribed(); }
  PetscInt num_unknowns() const override { return of_.num_unknowns(); }
  MPI_Comm comm() const override { return of_.comm(); }
  Handle<Vec> make_vector() const override { return of_.make_vector(); }

 private:
  StageEquation& of_;
  Handle<Vec> r_;
  std::vector<double> residuals_;
};

}  // namespace pliant::test
