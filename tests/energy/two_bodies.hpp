/// Two bodies that terms connect, and what holds for all such terms.
#pragma once

#include "energy/equation/incremental_potential.hpp"
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace pliant::test {

/// Two cubes beside each other, with terms between them, in a stage in which they move.
struct TwoBodies {
  static constexpr double gap = 0.3;
  using Terms = std::vector<std::unique_ptr<EnergyTerm>>;

  TwoBodies(MPI_Comm comm, const std::string& file, const std::function<Terms(const Solid&)>& make, int order = 1,
            Field displacement = rough_field(0.05, 7))
      : solid(comm, file, order, 1), terms(make(solid)), displacement_(std::move(displacement)) {
    std::vector<const EnergyTerm*> all;
    for (const auto& term : terms) all.push_back(term.get());
    potential.emplace(solid.layout(), solid.pattern(), all, solid.nothing_prescribed());
    stage.emplace(solid, 0.3, 0.05, rough_field(0.02, 3), rough_field(0.3, 4));
    potential->begin_stage(stage->point);
    const auto q = place();
    potential->freeze(q.get());
  }
  /// Where the bodies are.
  Handle<Vec> place() const { return solid.vector(displacement_); }
  Handle<Vec> direction() const { return solid.vector(rough_field(1.0, 5)); }

  Solid solid;
  Terms terms;
  std::optional<IncrementalPotential> potential;
  std::optional<TestStage> stage;

 private:
  Field displacement_;
};

/// The file of the mesh of TwoBodies.
struct TwoBodiesFile {
  Scratch scratch{MPI_COMM_WORLD};
  std::string name = scratch.file("two.msh", [](const std::string& f) { write_two_cubes(f, TwoBodies::gap); });
};

/// The gradient is that of the value, if there is a potential, and the Hessian, with its rank-one parts, that of the
/// gradient.
inline void expect_derivatives(TwoBodies& bodies) {
  IncrementalPotential& potential = *bodies.potential;
  const auto q = bodies.place(), d = bodies.direction();
  constexpr double h = 1e-6;
  const auto ahead = moved(q.get(), h, d.get()), behind = moved(q.get(), -h, d.get());
  const Handle<Vec> r = potential.make_vector(), before = potential.make_vector(), after = potential.make_vector();
  potential.gradient(q.get(), r.get());
  ASSERT_GT(norm(r.get()), 0.01);
  if (potential.is_potential()) {
    EXPECT_NEAR(dot(r.get(), d.get()), (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h),
                1e-6 * norm(r.get()));
  }
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::none);
  Handle<Vec> y = potential.make_vector();
  check(MatMult(K.get(), d.get(), y.get()));
  std::vector<RankOne> parts;
  for (std::size_t k = 0; k < potential.num_rank_one(); ++k) parts.push_back({0.0, potential.make_vector()});
  potential.rank_one_parts(q.get(), parts);
  for (const RankOne& part : parts) check(VecAXPY(y.get(), part.c * dot(part.g.get(), d.get()), part.g.get()));
  potential.gradient(ahead.get(), after.get());
  potential.gradient(behind.get(), before.get());
  check(VecAXPY(after.get(), -1.0, before.get()));
  check(VecScale(after.get(), 1.0 / (2.0 * h)));
  ASSERT_GT(norm(y.get()), 0.01);
  EXPECT_LT(distance(y.get(), after.get()), 1e-6 * norm(y.get()));
}

/// What acts on one body acts on the other.
inline void expect_no_resultant(TwoBodies& bodies) {
  const auto q = bodies.place();
  const Handle<Vec> r = bodies.potential->make_vector();
  bodies.potential->gradient(q.get(), r.get());
  std::array<double, 3> total{};
  {
    const ConstArrayView entries(r.get());
    for (PetscInt i = 0; i < 3 * bodies.solid.layout().num_owned_nodes; ++i) total[i % 3] += entries[i];
  }
  sum_in_place(MPI_COMM_WORLD, total);
  for (const double component : total) EXPECT_NEAR(component, 0.0, 1e-12 * norm(r.get()));
}

/// Values, forces, powers and energies.
inline std::vector<double> numbers_of(TwoBodies& bodies) {
  IncrementalPotential& potential = *bodies.potential;
  const auto q = bodies.place(), d = bodies.direction();
  const Handle<Vec> r = potential.make_vector();
  std::vector<double> numbers = potential.accounts().energies({0.3, 1.0, nullptr}, q.get(), nullptr);
  for (const TermPower& power : potential.accounts().powers(q.get(), d.get(), r.get())) {
    numbers.insert(numbers.end(), {power.supplied, power.dissipated, power.exerted});
  }
  potential.gradient(q.get(), r.get());
  numbers.insert(numbers.end(), {potential.value(q.get()), dot(r.get(), d.get()), norm(r.get())});
  return numbers;
}

inline void expect_numbers_of_one_rank(const std::string& file,
                                       const std::function<TwoBodies::Terms(const Solid&)>& make, int order = 1,
                                       const Field& displacement = rough_field(0.05, 7)) {
  TwoBodies many(MPI_COMM_WORLD, file, make, order, displacement),
      alone(MPI_COMM_SELF, file, make, order, displacement);
  const auto here = numbers_of(many), there = numbers_of(alone);
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_NEAR(here[i], there[i], 1e-11 * std::abs(there[i]) + 1e-14) << i;
  }
}

}  // namespace pliant::test
