// What the tests of rods and of fibres share: one term on the cells of a bent rod, as a potential.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "fem/cells.hpp"
#include "mesh/mesh.hpp"
#include "petsc/array_view.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::on_rod {

inline const std::vector<std::array<double, 3>> bent_curve{{0.0, 0.0, 0.0}, {0.3, 0.0, 0.1}, {0.5, 0.2, 0.0},
                                                           {0.6, 0.5, 0.1}, {0.4, 0.7, 0.3}, {0.1, 0.8, 0.2}};

/// Which of the terms of a rod acts.
enum class Acts { elasticity, viscosity };

/// A bent rod's cells, on which one term acts.
class TermOnRod {
 public:
  TermOnRod(MPI_Comm comm, int order, const AddedRod& rod) {
    MeshSource source;
    source.added_rods = {rod};
    mesh_ = read_mesh(comm, source);
    layout_ = make_layout(mesh_, order);
    pattern_ = std::make_unique<BlockPattern>(layout_);
  }

  /// The rod without ends, along bent_curve.
  static AddedRod rod() {
    AddedRod rod;
    rod.name = "rod";
    rod.points = bent_curve;
    rod.arms = {0.05, 0.03};
    return rod;
  }

  template <class Field>
  Handle<Vec> vector(Field field) const {
    Handle<Vec> x = potential_->make_vector();
    const ArrayView entries(x.get());
    for (PetscInt n = 0; n < layout_.num_owned_nodes; ++n) {
      const Vector3<double> u = field(Vector3<double>(layout_.position(n)));
      for (std::size_t i = 0; i < 3; ++i) entries[3 * n + static_cast<PetscInt>(i)] = u[i];
    }
    return x;
  }
  Handle<Vec> rough(double amount, double phase) const {
    return vector([&](const Vector3<double>& X) {
      return Vector3<double>{amount * std::sin(5.0 * X[0] + 3.0 * X[1] + phase), amount * std::cos(7.0 * X[2] - phase),
                             amount * std::sin(4.0 * X[1] - 6.0 * X[2] + 2.0 * phase)};
    });
  }
  IncrementalPotential& potential() { return *potential_; }
  Vec start() const { return q0_.get(); }
  double dt() const { return stage_.dt; }
  const NodeLayout& layout() const { return layout_; }
  const BlockPattern& pattern() const { return *pattern_; }
  double energy(Vec q) { return potential_->accounts().energies({0.0, 1.0, nullptr}, q, nullptr).front(); }

 protected:
  /// Lets the term act alone in a stage, with viscosity from a start that is not at rest.
  void act(const EnergyTerm& term, Acts acts) {
    const std::vector<char> prescribed(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0);
    potential_ =
        std::make_unique<IncrementalPotential>(layout_, *pattern_, std::vector<const EnergyTerm*>{&term}, prescribed);
    q0_ = potential_->make_vector();
    v0_ = potential_->make_vector();
    if (acts == Acts::viscosity) check(VecCopy(rough(0.03, 2.2).get(), q0_.get()));
    stage_.dt = 0.1;
    stage_.q0 = q0_.get();
    stage_.v0 = v0_.get();
    potential_->begin_stage(stage_);
  }

 private:
  Mesh mesh_;  // whose communicator the layout has
  NodeLayout layout_;
  std::unique_ptr<BlockPattern> pattern_;
  std::unique_ptr<IncrementalPotential> potential_;
  Handle<Vec> q0_, v0_;
  StagePoint stage_;
};

inline Handle<Vec> moved(Vec q, double h, Vec d) {
  Handle<Vec> x;
  check(VecDuplicate(q, x.out()));
  check(VecWAXPY(x.get(), h, d, q));
  return x;
}

inline double size(Vec x) {
  double result = 0.0;
  check(VecNorm(x, NORM_2, &result));
  return result;
}

inline double product(Vec x, Vec y) {
  double result = 0.0;
  check(VecDot(x, y, &result));
  return result;
}

/// The Hessian at q, along d, is that of differences of the gradient; its product is larger than `least`.
inline void expect_hessian_of_differences(IncrementalPotential& potential, Vec q, Vec d, double least) {
  constexpr double h = 1e-6;
  const Handle<Vec> ahead = moved(q, h, d), behind = moved(q, -h, d);
  const Handle<Vec> before = potential.make_vector(), after = potential.make_vector(), y = potential.make_vector();
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q, K.get(), Projection::none);
  check(MatMult(K.get(), d, y.get()));
  potential.gradient(ahead.get(), after.get());
  potential.gradient(behind.get(), before.get());
  check(VecAXPY(after.get(), -1.0, before.get()));
  check(VecScale(after.get(), 0.5 / h));
  ASSERT_GT(size(y.get()), least);
  check(VecAXPY(after.get(), -1.0, y.get()));
  EXPECT_LT(size(after.get()), 1e-7 * size(y.get()));
}

/// The viscosity's Hessian, and the power of its forces.
inline void expect_dissipation(TermOnRod& rod) {
  IncrementalPotential& potential = rod.potential();
  const Handle<Vec> q = rod.rough(0.06, 0.3), d = rod.rough(1.0, 1.1), r = potential.make_vector();
  expect_hessian_of_differences(potential, q.get(), d.get(), 0.1);
  const Handle<Vec> v = moved(q.get(), -1.0, rod.start());
  check(VecScale(v.get(), 1.0 / rod.dt()));
  const TermPower power = potential.accounts().powers(q.get(), v.get(), r.get()).back();
  EXPECT_GT(power.dissipated, 0.01);
  EXPECT_NEAR(-power.exerted, power.dissipated, 1e-11 * power.dissipated);
}

/// Value, energy, forces and Hessian, to be compared on several numbers of ranks.
inline std::vector<double> numbers_of(TermOnRod& rod) {
  IncrementalPotential& potential = rod.potential();
  const Handle<Vec> q = rod.rough(0.08, 0.3), d = rod.rough(1.0, 1.1), r = potential.make_vector(),
                    y = potential.make_vector();
  potential.gradient(q.get(), r.get());
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::positive_semidefinite);
  check(MatMult(K.get(), d.get(), y.get()));
  return {potential.value(q.get()), rod.energy(q.get()), size(r.get()), product(r.get(), d.get()), size(y.get())};
}

}  // namespace pliant::on_rod
