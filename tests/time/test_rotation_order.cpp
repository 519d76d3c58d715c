// The methods on SO(3): a free asymmetric top against Euler's equations, with the derivative of the exponential and
// without.
#include "time/bodies.hpp"
#include "time/every_method.hpp"
#include "time/integrator.hpp"

#include <cmath>
#include <memory>

namespace pliant::test_rotation_order {
namespace {

using test::Turning;

constexpr Vector3<double> moments = {1.0, 2.0, 3.0};
constexpr double end_time = 2.0;

Turning initial() {
  return {test::unit({0.3, -0.5, 0.7, 0.4}), {1.1, 0.8 + 0.1 * pliant::rank(MPI_COMM_WORLD), -0.9}};
}

/// What it would be like to take the rate of the coordinates for the angular velocity.
class WithoutDerivative final : public ConfigurationSpace {
 public:
  void difference(Vec a, Vec b, Vec xi) const override { space_.difference(a, b, xi); }
  void retract(Vec a, Vec xi, Vec b) const override { space_.retract(a, xi, b); }
  void velocity(Vec, Vec xi_dot, Vec v) const override { check(VecCopy(xi_dot, v)); }

 private:
  LieGroupSpace<SO3> space_;
};

/// I (v - v0)/dt = I v x v and v = velocity(xi, (xi - xi0)/dt) of one body per rank, by iteration: each gains a factor
/// of about dt, so that 30 reach rounding.
StageSolve picard(const std::shared_ptr<const ConfigurationSpace>& space) {
  const auto work = std::make_shared<std::array<Handle<Vec>, 2>>();
  *work = {test::zeros(3), test::zeros(3)};
  return [space, work](const StagePoint& stage, Vec q) {
    const auto& [rate, v] = *work;
    const auto v_0 = test::numbers_of<3>(stage.v0, 0);
    auto omega = v_0;
    check(VecCopy(stage.q0, q));
    for (int i = 0; i < 30; ++i) {
      const Vector3<double> L = {moments[0] * omega[0], moments[1] * omega[1], moments[2] * omega[2]};
      const Vector3<double> M = cross(L, omega);
      for (std::size_t k = 0; k < 3; ++k) omega[k] = v_0[k] + stage.dt * M[k] / moments[k];
      check(VecWAXPY(rate.get(), -1.0, stage.q0, q));
      check(VecScale(rate.get(), 1.0 / stage.dt));
      space->velocity(q, rate.get(), v.get());
      test::put(v.get(), 0, omega - test::numbers_of<3>(v.get(), 0));
      check(VecAXPY(q, stage.dt, v.get()));
    }
    return StageReport{};
  };
}

struct Error {
  double R = 0.0, omega = 0.0;
};

/// Largest over the ranks and five times.
Error error_after(const Method& method, const std::shared_ptr<const ConfigurationSpace>& space, int num_steps) {
  const auto q = test::zeros(4), v = test::zeros(3);
  test::put(q.get(), 0, initial().R);
  test::put(v.get(), 0, initial().omega);
  System system;
  system.solve = picard(space);
  system.space = space;
  Integrator integrator({method, Startup::dirk33}, std::move(system), {0.0, q.get(), v.get()});
  Error error;
  Turning exact = initial();
  const double dt = end_time / num_steps;
  for (int n = 1; n <= num_steps; ++n) {
    integrator.accept(integrator.attempt({n * dt, dt}));
    if (n % (num_steps / 5) != 0) continue;
    exact = test::reference_turning(moments, exact, end_time / 5);
    const auto R = test::numbers_of<4>(integrator.state().q.get(), 0);
    const auto away = SO3::difference(exact.R, R);
    error.R = std::max(error.R, std::hypot(away[0], away[1], away[2]));
    error.omega = std::max(error.omega,
                           test::largest_difference(exact.omega, test::numbers_of<3>(integrator.state().v.get(), 0)));
  }
  return {maximum(MPI_COMM_WORLD, error.R), maximum(MPI_COMM_WORLD, error.omega)};
}

class OrdersOnSO3 : public test::EveryMethod {
 protected:
  static void expect_orders(const std::shared_ptr<const ConfigurationSpace>& space, int order_R, int order_omega) {
    const Error coarse = error_after(GetParam(), space, 160), fine = error_after(GetParam(), space, 320);
    const double R = std::log2(coarse.R / fine.R), omega = std::log2(coarse.omega / fine.omega);
    EXPECT_NEAR(R, order_R, 0.1) << "errors " << coarse.R << ", " << fine.R;
    EXPECT_NEAR(omega, order_omega, 0.1) << "errors " << coarse.omega << ", " << fine.omega;
    RecordProperty("order_R", std::to_string(R));
    RecordProperty("order_omega", std::to_string(omega));
  }
};

INSTANTIATE_TEST_SUITE_P(Table, OrdersOnSO3, test::every_method(), test::method_name);

TEST_P(OrdersOnSO3, OrientationAndAngularVelocityHaveTheOrder) {
  expect_orders(std::make_shared<LieGroupSpace<SO3>>(), GetParam().order, GetParam().order);
}

// Euler's equations of a free body do not contain its orientation, which alone suffers.
TEST_P(OrdersOnSO3, WithoutTheDerivativeOfTheExponentialOrientationsAreOfSecondOrderAtMost) {
  expect_orders(std::make_shared<WithoutDerivative>(), std::min(2, GetParam().order), GetParam().order);
}

}  // namespace
}  // namespace pliant::test_rotation_order
