// Rigid bodies against closed forms: every method, by Newton's method on the residual.
#include "solver/jacobi.hpp"
#include "solver/tumbling.hpp"
#include "time/every_method.hpp"

#include <functional>
#include <limits>
#include <numbers>

namespace pliant::test_rigid_body {
namespace {

using test::diagonal;
using test::largest_difference;
using test::Random;
using test::Solver;
using test::Tumbling;
using test::Turning;

const MPI_Comm comm = MPI_COMM_WORLD;
const Method& dirk33 = *find_method("dirk33");

/// What accuracy owes to the method and not to the ranks is computed by rank 0 alone.
bool somebody_else_computes() {
  return rank(comm) != 0;
}

/// Bodies of one rank.
template <class Group>
Tumbling<Group> alone(const Method& method, const std::vector<typename Tumbling<Group>::Body>& bodies,
                      const Vector3<double>& gravity, Solver solver = Solver::newton) {
  return {method, bodies, gravity, solver, MPI_COMM_SELF};
}

/// Largest angle between the orientations (and difference of places), and largest difference of the velocities.
struct Error {
  double q = 0.0, v = 0.0;

  template <class Group>
  void look(const Tumbling<Group>& motion, const typename Tumbling<Group>::Configuration& exact_q,
            const typename Tumbling<Group>::Velocity& exact_v) {
    q = std::max(q, largest_difference(Group::difference(exact_q, motion.q(0)), {}));
    v = std::max(v, largest_difference(exact_v, motion.v(0)));
  }
};

void expect_order(int order, int num_coarse, const std::function<Error(int num_steps)>& error_after) {
  const Error coarse = error_after(num_coarse), fine = error_after(2 * num_coarse);
  EXPECT_NEAR(std::log2(coarse.q / fine.q), order, 0.15) << "errors in q " << coarse.q << ", " << fine.q;
  EXPECT_NEAR(std::log2(coarse.v / fine.v), order, 0.15) << "errors in v " << coarse.v << ", " << fine.v;
}

template <class T>
class RigidBodyEquation : public testing::Test {};
using Groups = testing::Types<SO3, SE3>;
TYPED_TEST_SUITE(RigidBodyEquation, Groups);

TYPED_TEST(RigidBodyEquation, HessianIsTheDerivativeOfTheResidual) {
  constexpr std::size_t n = TypeParam::num_coordinates;
  Random random(1);
  std::vector<RigidBody> bodies(test::num_bodies());
  for (auto& body : bodies) {
    const Tensor3<double> A = {random.numbers<9>()};
    body = {1.5, {0.3, -0.2, 0.4}, matmul(transpose(A), A)};
  }
  RigidBodies<TypeParam> equation(comm, bodies, {1.0, 2.0, -9.81});
  const auto q_n = equation.make_configuration();
  const auto xi_0 = equation.make_vector(), v_0 = equation.make_vector(), xi = equation.make_vector(),
             plus = equation.make_vector(), minus = equation.make_vector();
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    test::put(q_n.get(), k, test::random_configuration<TypeParam>(random));
    test::put(xi_0.get(), k, random.numbers<n>());
    test::put(v_0.get(), k, random.numbers<n>());
    test::put(xi.get(), k, random.numbers<n>());
  }
  StagePoint stage{0.0, 0.5, xi_0.get(), v_0.get()};
  stage.centre = q_n.get();
  equation.begin_stage(stage);
  const auto K = equation.make_hessian();
  equation.hessian(xi.get(), K.get(), Projection::none);

  constexpr double h = 1e-5;  // error of the differences: h^2, and 1e-16 / h
  PetscReal scale = 0.0;
  check(MatNorm(K.get(), NORM_INFINITY, &scale));
  const auto moved = [&](std::size_t j, double by, Vec r) {
    const auto at = equation.make_vector();
    check(VecCopy(xi.get(), at.get()));
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      auto numbers = test::numbers_of<n>(at.get(), k);
      numbers[j] += by;
      test::put(at.get(), k, numbers);
    }
    equation.gradient(at.get(), r);
  };
  PetscInt first = 0;
  check(VecGetOwnershipRange(xi.get(), &first, nullptr));
  double asymmetry = 0.0;
  for (std::size_t j = 0; j < n; ++j) {
    moved(j, h, plus.get());
    moved(j, -h, minus.get());
    check(VecAXPBY(plus.get(), -0.5 / h, 0.5 / h, minus.get()));
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const auto difference = test::numbers_of<n>(plus.get(), k);
      for (std::size_t i = 0; i < n; ++i) {
        const auto row = first + static_cast<PetscInt>(n * k + i), column = first + static_cast<PetscInt>(n * k + j);
        double K_ij = 0.0, K_ji = 0.0;
        check(MatGetValues(K.get(), 1, &row, 1, &column, &K_ij));
        check(MatGetValues(K.get(), 1, &column, 1, &row, &K_ji));
        EXPECT_NEAR(K_ij, difference[i], 1e-8 * scale) << i << ", " << j;
        asymmetry = std::max(asymmetry, std::abs(K_ij - K_ji));
      }
    }
  }
  EXPECT_GT(maximum(comm, asymmetry), 0.01 * scale);
  EXPECT_FALSE(equation.is_potential());
  EXPECT_EQ(equation.symmetry(), Symmetry::unsymmetric);
}

// Spread over the ranks or alone, by Newton's method on the residual or by elimination: the same motion.
TYPED_TEST(RigidBodyEquation, BodiesMoveAsIfAlone) {
  constexpr std::size_t n = TypeParam::num_coordinates;
  using Motion = Tumbling<TypeParam>;
  Random random(2);
  std::vector<typename Motion::Body> bodies(test::num_bodies());
  for (auto& body : bodies) {
    const Tensor3<double> A = {random.numbers<9>()};
    const Tensor3<double> inertia = add_to_diagonal(matmul(transpose(A), A), 1.0);
    body = {{1.5, {0.3, -0.2, 0.4}, inertia}, test::random_configuration<TypeParam>(random), random.numbers<n>()};
  }
  const Vector3<double> gravity = {1.0, 2.0, -9.81};
  Motion together(dirk33, bodies, gravity, Solver::newton);
  for (int i = 0; i < 2; ++i) together.step(0.05);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    Motion alone(dirk33, {bodies[k]}, gravity, Solver::body_by_body, MPI_COMM_SELF);
    for (int i = 0; i < 2; ++i) alone.step(0.05);
    EXPECT_LT(largest_difference(TypeParam::difference(alone.q(0), together.q(k)), {}), 1e-11);
    EXPECT_LT(largest_difference(alone.v(0), together.v(k)), 1e-11);
  }
}

// Where the line search may go: to the full turn.
TEST(RigidBodyStep, EndsWhereCoordinatesDo) {
  const std::vector<RigidBody> bodies(rank(comm) == 1 ? 0 : 1, {1.0, {}, diagonal({1, 1, 1})});
  RigidBodies<SO3> equation(comm, bodies, {});
  const auto q = equation.make_vector(), d = equation.make_vector();
  if (!bodies.empty()) {
    test::put<3>(q.get(), 0, {0.0, 1.0, 0.0});
    test::put<3>(d.get(), 0, {0.0, -2.0, 0.0});
  }
  EXPECT_NEAR(equation.max_step(q.get(), d.get()), std::numbers::pi + 0.5, 1e-14);
}

/// Moments of inertia I, I, J; free. Source: Drake, benchmarks/free_body.
Turning axisymmetric(double I, double J, const Vector3<double>& w0, double t) {
  const double s = w0[2] * (I - J) / I, c = std::cos(s * t), d = std::sin(s * t);
  const double p = std::hypot(w0[0], w0[1], w0[2] * J / I), k = w0[2] * J / (I * p);
  const double cp = std::cos(p * t / 2), sp = std::sin(p * t / 2), cs = std::cos(s * t / 2), ss = std::sin(s * t / 2);
  return {{cp * cs - k * sp * ss, sp / p * (w0[0] * cs + w0[1] * ss), sp / p * (-w0[0] * ss + w0[1] * cs),
           k * sp * cs + cp * ss},
          {w0[0] * c + w0[1] * d, -w0[0] * d + w0[1] * c, w0[2]}};
}

TEST(AxisymmetricBody, FollowsItsClosedForm) {
  if (somebody_else_computes()) return;
  const Vector3<double> w0 = {2.0, -3.0, 5.0};
  const Turning exact = axisymmetric(0.04, 0.02, w0, 3.0);
  EXPECT_LT(largest_difference(exact.R, {-.6887509702, .0049235719, .2412619743, -.6836596516}), 1e-10);
  EXPECT_LT(largest_difference(exact.omega, {-2.1207292947, -2.9159059071, 5.0}), 1e-10);

  expect_order(3, 100, [&](int num_steps) {
    auto motion = alone<SO3>(dirk33, {{{1.0, {}, diagonal({0.04, 0.04, 0.02})}, {1, 0, 0, 0}, w0}}, {});
    for (int n = 0; n < num_steps; ++n) motion.step(3.0 / num_steps);
    Error error;
    error.look(motion, exact.R, exact.omega);
    return error;
  });
}

/// A row of the flips about the intermediate axis: principal moments 1, 2, 3, free.
struct Flip {
  Vector3<double> omega_0;
  bool starts_at_quarter_period;
  double period;
  Vector3<double> omega_5;  ///< at t = 5
};

const std::array<Flip, 4> flips = {{{{.01, 1, 0}, true, 41.50921953, {.0897806017, .9960117688, -.0515123171}},
                                    {{.1, 1, 0}, true, 25.51097788, {.7541770927, .6642416073, -.4315796902}},
                                    {{0, 1, .1}, true, 21.64212234, {-.9717339238, .2360787607, .5698733247}},
                                    {{1, 0, .5}, false, 14.94077868, {.5983353757, .8012457664, -.1897412465}}}};

/// Euler's equations in closed form (Landau & Lifshitz, Mechanics, 37), all components >= 0 at the start.
struct AsymmetricTop {
  AsymmetricTop(const Vector3<double>& I, const Flip& flip) : flip_(flip) {
    const Vector3<double> w = flip.omega_0;
    const double T2 = I[0] * w[0] * w[0] + I[1] * w[1] * w[1] + I[2] * w[2] * w[2];
    const double L2 = std::pow(I[0] * w[0], 2) + std::pow(I[1] * w[1], 2) + std::pow(I[2] * w[2], 2);
    // a turns to and fro, c does not: which of the axes 1 and 3 is which depends on the energy.
    a_ = L2 > T2 * I[1] ? 0 : 2;
    c_ = 2 - a_;
    const double Ia = I[a_], Ib = I[1], Ic = I[c_];
    m_ = (Ib - Ia) * (Ic * T2 - L2) / ((Ic - Ib) * (L2 - Ia * T2));
    p_ = std::sqrt((Ic - Ib) * (L2 - T2 * Ia) / (Ia * Ib * Ic));
    amplitude_[a_] = std::sqrt((Ic * T2 - L2) / (Ia * (Ic - Ia)));
    amplitude_[1] = std::sqrt((Ic * T2 - L2) / (Ib * (Ic - Ib)));
    amplitude_[c_] = std::sqrt((L2 - Ia * T2) / (Ic * (Ic - Ia)));
  }
  double period() const { return 4.0 * test::quarter_period(m_) / p_; }
  Vector3<double> omega(double t) const {
    const auto [sn, cn, dn] = test::jacobi(p_ * t + (flip_.starts_at_quarter_period ? period() * p_ / 4 : 0.0), m_);
    Vector3<double> result;
    result[a_] = amplitude_[a_] * cn, result[1] = amplitude_[1] * sn, result[c_] = amplitude_[c_] * dn;
    return result;
  }

 private:
  Flip flip_;
  std::size_t a_, c_;
  double m_, p_;
  Vector3<double> amplitude_{};
};

TEST(IntermediateAxis, FlipsAsItsClosedFormSays) {
  if (somebody_else_computes()) return;
  const Vector3<double> I = {1, 2, 3};
  std::vector<Tumbling<SO3>::Body> bodies;
  std::vector<AsymmetricTop> exact;
  for (const Flip& flip : flips) {
    exact.emplace_back(I, flip);
    bodies.push_back({{1.0, {}, diagonal(I)}, {1, 0, 0, 0}, flip.omega_0});
    EXPECT_NEAR(exact.back().period(), flip.period, 1e-8);
    EXPECT_LT(largest_difference(exact.back().omega(0.0), flip.omega_0), 1e-12);
    EXPECT_LT(largest_difference(exact.back().omega(5.0), flip.omega_5), 1e-10);
  }
  // At t = 5, and half a period of the slowest after the start, when its intermediate axis points the other way.
  const double half_period = 0.5 * exact[0].period();
  EXPECT_NEAR(exact[0].omega(half_period)[1], -1.0, 1e-9);
  for (const double t : {5.0, half_period}) {
    expect_order(3, 200, [&](int num_steps) {
      auto motion = alone<SO3>(dirk33, bodies, {}, Solver::body_by_body);
      for (int n = 0; n < num_steps; ++n) motion.step(t / num_steps);
      Error error;
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        error.v = std::max(error.v, largest_difference(motion.v(k), exact[k].omega(t)));
      }
      error.q = error.v;  // orientations have a test of their own
      return error;
    });
  }
}

/// m g l = 0.981 N m about the pivot, spinning at 100 rad/s about an axis leaning by 60 degrees.
struct HeavyTop {
  static constexpr double I1 = 0.02, I3 = 0.01, mgl = 0.981, w3 = 100.0, theta = std::numbers::pi / 3;
  static constexpr Vector3<double> gravity = {0.0, 0.0, -9.81};
  static RigidBody body() { return {1.0, {0.0, 0.0, 0.1}, diagonal({I1, I1, I3})}; }
  /// Rate of steady precession, the slow (-1) or the fast (+1) one [rad/s].
  static double precession(int sign) {
    const double c = std::cos(theta), root = std::sqrt(I3 * I3 * w3 * w3 - 4 * I1 * mgl * c);
    return (I3 * w3 + sign * root) / (2 * I1 * c);
  }
  static Turning steady(int sign, double t) {
    const double Omega = precession(sign), spin = w3 - Omega * std::cos(theta);
    const Quaternion lean = exponential({theta, 0, 0});
    const Quaternion R = product(exponential({0, 0, Omega * t}), product(lean, exponential({0, 0, spin * t})));
    return {R, turn(inverse(R), {0, 0, Omega}) + Vector3<double>{0, 0, spin}};
  }
};

TEST(HeavySymmetricTop, PrecessesSteadily) {
  if (somebody_else_computes()) return;
  EXPECT_NEAR(HeavyTop::precession(-1), .9908171870, 1e-10);
  EXPECT_NEAR(HeavyTop::precession(+1), 99.0091828130, 1e-10);
  for (const int sign : {-1, +1}) {
    expect_order(3, 50, [&](int num_steps) {
      const auto start = HeavyTop::steady(sign, 0.0), exact = HeavyTop::steady(sign, 0.1);
      auto motion = alone<SO3>(dirk33, {{HeavyTop::body(), start.R, start.omega}}, HeavyTop::gravity);
      for (int n = 0; n < num_steps; ++n) motion.step(0.1 / num_steps);
      Error error;
      error.look(motion, exact.R, exact.omega);
      return error;
    });
  }
}

/// In free fall and tumbling, followed at a point that is not the centre of mass, which goes along a parabola.
struct Thrown {
  static constexpr Vector3<double> I = {1.0, 2.0, 3.0};  ///< about the centre of mass, along the body's axes
  static constexpr Vector3<double> c = {0.3, -0.2, 0.5};
  static constexpr double m = 1.3;
  static constexpr Vector3<double> gravity = {0.1, 0.0, -2.0}, velocity = {0.4, -0.3, 1.2};  ///< of the centre of mass

  static RigidBody body() {
    const Tensor3<double> steiner = make_tensor([](int i, int j) {
      return m * ((i == j ? dot(c, c) : 0.0) - c[static_cast<std::size_t>(i)] * c[static_cast<std::size_t>(j)]);
    });
    return {m, c, diagonal(I) + steiner};
  }
  static Tumbling<SE3>::Body at(const Turning& turning, double t) {
    const auto& [R, w] = turning;
    const Vector3<double> x = t * velocity + 0.5 * t * t * gravity - turn(R, c);
    const Vector3<double> u = turn(inverse(R), velocity + t * gravity) - cross(w, c);
    return {body(), {x[0], x[1], x[2], R[0], R[1], R[2], R[3]}, {w[0], w[1], w[2], u[0], u[1], u[2]}};
  }
};

class RigidBodyOrders : public test::EveryMethod {};

INSTANTIATE_TEST_SUITE_P(Table, RigidBodyOrders, test::every_method(), test::method_name);

TEST_P(RigidBodyOrders, ATumblingBodyInFreeFallHasTheOrder) {
  if (somebody_else_computes()) return;
  const Turning start = {test::unit({0.3, -0.5, 0.7, 0.4}), {1.1, 0.8, -0.9}};
  std::array<Tumbling<SE3>::Body, 2> exact;
  for (std::size_t i = 0; i < 2; ++i) {
    const double t = 0.5 + 0.5 * static_cast<double>(i);
    exact[i] = Thrown::at(test::reference_turning(Thrown::I, start, t), t);
  }
  expect_order(GetParam().order, 40, [&](int num_steps) {
    auto motion = alone<SE3>(GetParam(), {Thrown::at(start, 0.0)}, Thrown::gravity);
    Error error;
    for (std::size_t i = 0; i < 2; ++i) {
      for (int n = 0; n < num_steps / 2; ++n) motion.step(1.0 / num_steps);
      error.look(motion, exact[i].q, exact[i].v);
    }
    return error;
  });
}

/// Angular momentum of a body that turns about the origin, in space.
Vector3<double> angular_momentum(const Vector3<double>& I, const Tumbling<SO3>& motion) {
  const auto w = motion.v(0);
  return turn(SO3::rotation(motion.q(0)), {I[0] * w[0], I[1] * w[1], I[2] * w[2]});
}

// Energy and |L|^2 are quadratic in the angular velocity, whose equations do not contain the orientation: symplectic
// methods keep both to rounding. The direction of L in space they keep to second order, without drift.
TEST(FreeTop, KeepsItsInvariantsOver100000Steps) {
  if (somebody_else_computes()) return;
  constexpr int num_steps = 100000;
  constexpr double rounding = num_steps * std::numeric_limits<double>::epsilon();
  const Vector3<double> I = {1, 2, 3};
  for (const Method& method : methods()) {
    if (!method.symplectic) continue;
    auto motion =
        alone<SO3>(method, {{{1.0, {}, diagonal(I)}, {1, 0, 0, 0}, {0.1, 1.0, 0.2}}}, {}, Solver::body_by_body);
    const double E_0 = motion.energy();
    const Vector3<double> L_0 = angular_momentum(I, motion);
    double early = 0.0, late = 0.0;
    for (int n = 1; n <= num_steps; ++n) {
      motion.step(0.1);
      if (n % 97 != 0) continue;
      const Vector3<double> L = angular_momentum(I, motion);
      double& slot = n < num_steps / 2 ? early : late;
      slot = std::max(slot, largest_difference(L, L_0));
      EXPECT_NEAR(motion.energy(), E_0, rounding * E_0) << method.name;
      EXPECT_NEAR(dot(L, L), dot(L_0, L_0), rounding * dot(L_0, L_0)) << method.name;
    }
    EXPECT_LT(early, 3e-3) << method.name;  // dt^2 / 12 [v, v'] in a step
    EXPECT_LT(late, 1.01 * early) << method.name;
    EXPECT_LT(test::distance_from_orthogonal(SO3::rotation(motion.q(0))), 1e-14) << method.name;
  }
}

// Released without precession the top nods. L along its axis is kept to rounding; energy and L along gravity are kept
// to second order. implicit-midpoint is its own inverse and lets neither drift; the two halves of symplectic-dirk22
// share one chart, which is neither symmetric nor symplectic: over 1e5 such steps its error changes by a sixth.
TEST(HeavySymmetricTop, BoundsItsInvariantsOverManySteps) {
  if (somebody_else_computes()) return;
  constexpr int num_steps = 20000;
  const Vector3<double> I = {HeavyTop::I1, HeavyTop::I1, HeavyTop::I3};
  for (const Method& method : methods()) {
    if (!method.symplectic) continue;
    const Quaternion lean = exponential({HeavyTop::theta, 0, 0});
    auto motion =
        alone<SO3>(method, {{HeavyTop::body(), lean, {0, 0, HeavyTop::w3}}}, HeavyTop::gravity, Solver::body_by_body);
    const double E_0 = motion.energy(), Lz_0 = angular_momentum(I, motion)[2];
    std::array<double, 2> E{}, Lz{};  // largest errors of the first and of the second half
    for (int n = 0; n < num_steps; ++n) {
      motion.step(0.002);
      const auto half = static_cast<std::size_t>(2 * n / num_steps);
      E[half] = std::max(E[half], std::abs(motion.energy() - E_0));
      Lz[half] = std::max(Lz[half], std::abs(angular_momentum(I, motion)[2] - Lz_0));
      EXPECT_NEAR(motion.v(0)[2], HeavyTop::w3, 1e-13 * num_steps * HeavyTop::w3) << method.name;
    }
    const double drift = method.num_stages == 1 ? 0.01 : 0.05;
    EXPECT_LT(E[0], 1e-4) << method.name;  // of mgl = 0.981 J, at 0.2 rad a step
    EXPECT_LT(Lz[0], 3e-4) << method.name;
    EXPECT_NEAR(E[1] / E[0], 1.0, drift) << method.name;
    EXPECT_NEAR(Lz[1] / Lz[0], 1.0, drift) << method.name;
  }
}

}  // namespace
}  // namespace pliant::test_rigid_body
