// Steps take no memory: neither by operator new, nor in PETSc, which numbers its objects as they are made.
#include "time/count_allocations.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"
#include "time/ode.hpp"

#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_memory {
namespace {

class MemoryOfSteps : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, MemoryOfSteps, test::every_method(), test::method_name);

PetscObjectId id_of_a_new_object() {
  PetscObjectId id = 0;
  check(PetscObjectGetId(reinterpret_cast<PetscObject>(test::vector_of({1.0}).get()), &id));
  return id;
}

/// q'' = -q, z' = q - z and w' = z: the hooks themselves take no memory.
System oscillator() {
  System system;
  system.solve = [](const StagePoint& stage, Vec q) {  // q = (q0 + dt v0) / (1 + dt^2)
    check(VecWAXPY(q, stage.dt, stage.v0, stage.q0));
    check(VecScale(q, 1.0 / (1.0 + stage.dt * stage.dt)));
    return StageReport{};
  };
  system.internal.end_stage = [](const StagePoint& stage, Vec q, Vec z) {
    check(VecWAXPY(z, stage.dt, q, stage.z0));
    check(VecScale(z, 1.0 / (1.0 + stage.dt)));
  };
  system.quadratures.rates = [](const StagePoint&, Vec, Vec v, Vec, std::span<double> k_w) {
    check(VecSum(v, &k_w[0]));
  };
  return system;
}

TEST_P(MemoryOfSteps, IsTakenOnceAndForAll) {
  const Handle<Vec> q = test::vector_of({1.0, 0.5}), v = test::vector_of({0.0, 0.2}), z = test::vector_of({0.0, 0.0});
  const std::vector<double> w{0.0};
  for (const Startup startup : {Startup::ramp, Startup::dirk33}) {
    Integrator integrator({GetParam(), startup, ErrorEstimate::local}, oscillator(),
                          {0.0, q.get(), v.get(), z.get(), w});
    const PetscObjectId first = id_of_a_new_object(), before = id_of_a_new_object();
    const std::size_t num_before = test::num_allocations();
    for (int n = 1; n <= 8; ++n) {
      (void)integrator.attempt({n * 0.1, 0.1});
      integrator.accept(integrator.attempt({n * 0.1, 0.1}));
      if (n == 5) integrator.restart();
    }
    EXPECT_EQ(test::num_allocations(), num_before);
    EXPECT_EQ(id_of_a_new_object() - before, before - first);
    EXPECT_NE(integrator.state().w[0], 0.0);
  }
}

}  // namespace
}  // namespace pliant::test_memory
