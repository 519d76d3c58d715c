// Bending of shells: exact for constant curvature, derivatives, rigid motions, ranks.
#include "energy/shell/shell_bending.hpp"
#include "energy/solid.hpp"
#include "fem/body.hpp"

#include <cmath>
#include <memory>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_shell_bending {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr BendingStiffness plate{3.0, 0.3};

/// The angles of a patch whose corners are lifted by a small deflection.
std::array<double, 3> angles(const HingePatch& patch, const std::function<double(const Vector3<double>&)>& deflection) {
  const auto lifted = [&](Vector3<double> X) {
    X[2] += deflection(X);
    return X;
  };
  std::array<double, 3> result{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (!patch.has_other[k]) continue;
    const Vector3<double> a = lifted(patch.corners[k]);
    result[k] = hinge_angle<double>(lifted(patch.corners[(k + 1) % 3]) - a, lifted(patch.corners[(k + 2) % 3]) - a,
                                    lifted(patch.others[k]) - a);
  }
  return result;
}

HingePatch irregular() {
  return {{{{0.0, 0.0, 0.0}, {1.0, 0.1, 0.0}, {0.3, 0.9, 0.0}}},
          {{{0.6, -0.7, 0.0}, {1.1, 1.0, 0.0}, {-0.5, 0.6, 0.0}}},
          {true, true, true}};
}

TEST(HingeMatrix, HasTheEnergyOfAPlateOfConstantCurvature) {
  constexpr double size = 1e-5;
  const HingePatch patch = irregular();
  const double area = 0.5 * norm(cross(patch.corners[1], patch.corners[2]));
  const auto M = hinge_matrix(patch, plate.rigidity, plate.poissons_ratio);
  for (const auto& [xx, yy, xy] : {std::array{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}, {1.0, -0.5, 0.7}}) {
    const auto theta = angles(patch, [&](const Vector3<double>& X) {
      return size * (0.5 * xx * X[0] * X[0] + 0.5 * yy * X[1] * X[1] + xy * X[0] * X[1]);
    });
    double energy = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) energy += 0.5 * M[3 * i + j] * theta[i] * theta[j] / (size * size);
    }
    const double nu = plate.poissons_ratio, trace = xx + yy;
    const double expected =
        0.5 * area * plate.rigidity * ((1.0 - nu) * (xx * xx + yy * yy + 2.0 * xy * xy) + nu * trace * trace);
    EXPECT_NEAR(energy, expected, 2e-3 * expected);  // the regularization
  }
}

TEST(HingeMatrix, OfAFreeEdgeHasTheLeastEnergy) {
  HingePatch patch = irregular();
  const auto whole = hinge_matrix(patch, plate.rigidity, plate.poissons_ratio);
  patch.has_other[1] = false;
  const auto part = hinge_matrix(patch, plate.rigidity, plate.poissons_ratio);
  // Without the second angle: the Schur complement.
  for (const std::size_t i : {0, 2}) {
    for (const std::size_t j : {0, 2}) {
      const double expected = whole[3 * i + j] - whole[3 * i + 1] * whole[3 + j] / whole[4];
      EXPECT_NEAR(part[3 * i + j], expected, 1e-12 * whole[4]);
    }
  }
  for (std::size_t j = 0; j < 3; ++j) EXPECT_EQ(part[3 + j], 0.0);
  patch.has_other = {false, false, false};
  for (const double entry : hinge_matrix(patch, plate.rigidity, plate.poissons_ratio)) EXPECT_EQ(entry, 0.0);
}

TEST(HingeAngle, IsThatOfTheFold) {
  for (const double angle : {-2.5, -0.3, 0.0, 1e-9, 0.8, 3.0}) {
    const Vector3<double> e{2.0, 0.0, 0.0}, u{0.5, 1.5, 0.0}, v{1.0, -std::cos(angle), std::sin(angle)};
    EXPECT_NEAR(hinge_angle<double>(e, u, v), angle, 1e-15);
  }
}

/// The whole surface of a body resists bending.
struct Bent {
  Solid solid;
  ShellBending term;
  IncrementalPotential potential;
  TestStage stage;

  Bent(MPI_Comm on, const std::string& file, const BodySpec& body)
      : solid(on, file, body.order, 1),
        term(solid.layout(), surface_facets(solid.mesh(), solid.layout(), [](const Point&) { return true; }),
             [](const Point& X) {
               return BendingStiffness{2.0 + X[0], 0.3};
             }),
        potential(solid.layout(), solid.pattern(), {&term}, solid.nothing_prescribed()),
        stage(solid, 0.7, 0.05, test::rough_field(0.01, 3), test::rough_field(0.3, 4)) {
    potential.begin_stage(stage.point);
  }
  Handle<Vec> gradient(Vec q) {
    Handle<Vec> r = potential.make_vector();
    potential.gradient(q, r.get());
    return r;
  }
};

class Bending : public ::testing::TestWithParam<BodySpec> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam()); });
  Bent bent_{comm, file_, GetParam()};
};

INSTANTIATE_TEST_SUITE_P(Elements, Bending,
                         ::testing::Values(BodySpec{1, Shape::jittered, 3}, BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Bending, DerivativesAreThoseOfDifferences) {
  IncrementalPotential& potential = bent_.potential;
  const Handle<Vec> q = bent_.solid.vector(test::strained), d = bent_.solid.vector(test::rough_field(1.0, 11));
  constexpr double h = 1e-6;
  const Handle<Vec> ahead = test::moved(q.get(), h, d.get()), behind = test::moved(q.get(), -h, d.get());
  const Handle<Vec> r = bent_.gradient(q.get()), next = bent_.gradient(ahead.get()),
                    last = bent_.gradient(behind.get());
  const double slope = (potential.value(ahead.get()) - potential.value(behind.get())) / (2.0 * h);
  ASSERT_GT(test::norm(r.get()), 0.1);
  EXPECT_NEAR(test::dot(r.get(), d.get()), slope, 1e-7 * test::norm(r.get()) * test::norm(d.get()));
  const Handle<Mat> K = potential.make_hessian();
  potential.hessian(q.get(), K.get(), Projection::none);
  const Handle<Vec> y = potential.make_vector();
  check(MatMult(K.get(), d.get(), y.get()));
  check(VecAXPY(next.get(), -1.0, last.get()));
  check(VecScale(next.get(), 0.5 / h));
  ASSERT_GT(test::norm(y.get()), 0.1);
  EXPECT_LT(test::distance(next.get(), y.get()), 1e-7 * test::norm(y.get()));
  potential.hessian(q.get(), K.get(), Projection::positive_semidefinite);
  check(MatMult(K.get(), d.get(), y.get()));
  EXPECT_GE(test::dot(y.get(), d.get()), 0.0);
}

TEST_P(Bending, RigidMotionsCostNothing) {
  const Handle<Vec> q = bent_.solid.vector([](const Point& x) -> Point {
    return {-x[0] - x[1] + 0.3, x[0] - x[1] - 0.2, 4.0};  // a quarter of a turn, and a shift
  });
  EXPECT_LT(test::norm(bent_.gradient(q.get()).get()), 1e-9);
  EXPECT_EQ(test::norm(bent_.gradient(bent_.solid.vector(test::at_rest).get()).get()), 0.0);
}

TEST_P(Bending, NumbersAreThoseOfOneRank) {
  Bent alone(MPI_COMM_SELF, file_, GetParam());
  const auto numbers = [](Bent& bent) {
    const Handle<Vec> q = bent.solid.vector(test::strained), d = bent.solid.vector(test::rough_field(1.0, 11)),
                      y = bent.potential.make_vector(), r = bent.gradient(q.get());
    const Handle<Mat> K = bent.potential.make_hessian();
    bent.potential.hessian(q.get(), K.get(), Projection::none);
    check(MatMult(K.get(), d.get(), y.get()));
    return std::array{bent.potential.value(q.get()),
                      bent.potential.accounts().energies({0.0, 1.0, nullptr}, q.get(), nullptr).front(),
                      test::norm(r.get()), test::norm(y.get()), test::dot(r.get(), d.get())};
  };
  const auto here = numbers(bent_), expected = numbers(alone);
  for (std::size_t k = 0; k < here.size(); ++k) {
    EXPECT_NEAR(here[k], expected[k], 1e-12 * std::abs(expected[k])) << k;
  }
}

}  // namespace
}  // namespace pliant::test_shell_bending
