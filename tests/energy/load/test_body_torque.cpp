// Torques on rigid bodies: derivatives, no force, the power on a body that turns.
#include "energy/load/body_torque.hpp"
#include "energy/two_bodies.hpp"

namespace pliant::test_body_torque {
namespace {

using test::Point;
using test::Solid;
using test::TwoBodies;
using test::TwoBodiesFile;

const Vector3<double> tau{2.0, -1.0, 3.0};

TwoBodies::Terms make(const Solid& solid) {
  const std::vector<int> body_of_cell(static_cast<std::size_t>(solid.layout().num_local_cells), 0);
  TwoBodies::Terms terms;
  terms.push_back(std::make_unique<BodyTorque>(solid.layout(), largest_cell_of(solid.layout(), body_of_cell, 0),
                                               std::array{Expression(tau[0]), Expression(tau[1]), Expression(tau[2])}));
  return terms;
}

class BodyTorques : public ::testing::Test {
 protected:
  TwoBodiesFile file_;
};

TEST_F(BodyTorques, DerivativesAreThoseOfDifferences) {
  TwoBodies bodies(MPI_COMM_WORLD, file_.name, make);
  EXPECT_FALSE(bodies.potential->is_potential());
  test::expect_derivatives(bodies);
}

TEST_F(BodyTorques, HaveNoResultant) {
  TwoBodies bodies(MPI_COMM_WORLD, file_.name, make);
  test::expect_no_resultant(bodies);
}

TEST_F(BodyTorques, AreThoseOfOneRank) {
  test::expect_numbers_of_one_rank(file_.name, make);
}

// The body is turned by a quarter about z, and turns with w about any point: the power is tau . w.
TEST_F(BodyTorques, HaveThePowerOfTheirBody) {
  TwoBodies bodies(MPI_COMM_WORLD, file_.name, make);
  const Vector3<double> w{0.3, 0.7, -0.2};
  const auto turned = [](const Point& X) { return Vector3<double>{-X[1], X[0], X[2]}; };
  const auto q = bodies.solid.vector([&](const Point& X) {
    const auto x = turned(X);
    return Point{x[0] - X[0], x[1] - X[1], x[2] - X[2]};
  });
  const auto v = bodies.solid.vector([&](const Point& X) {
    const auto u = cross(w, turned(X));
    return Point{u[0] + 1.0, u[1], u[2]};
  });
  const Handle<Vec> r = bodies.potential->make_vector();
  bodies.potential->gradient(q.get(), r.get());
  EXPECT_NEAR(-test::dot(r.get(), v.get()), dot(tau, w), 1e-12);
}

}  // namespace
}  // namespace pliant::test_body_torque
