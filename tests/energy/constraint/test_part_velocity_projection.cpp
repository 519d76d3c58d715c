// Velocities of rigid parts, projected by fields that are found once, and by a system that is solved each time.
#include "energy/constraint/part_velocity_projection.hpp"
#include "energy/tied_body.hpp"

namespace pliant::test_part_velocity_projection {
namespace {

using test::Point;
using test::Scratch;
using test::Shape;
using test::TestConstraint;
using test::TiedBody;

const MPI_Comm comm = MPI_COMM_WORLD;

TestConstraint turning(const Region& region, const Point& centre) {
  TestConstraint constraint;
  constraint.given.rigid.emplace();
  constraint.given.rigid->centre = centre;
  constraint.turning = region;
  return constraint;
}

TEST(PartVelocityProjection, IsThatOfTheWholeMass) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 4});
  });
  for (const bool is_held : {false, true}) {
    std::vector<TestConstraint> constraints{
        turning([](const Point& x) { return x[0] > 0.7; }, {1.0, 0.5, 0.5}),
        turning([](const Point& x) { return x[0] < 0.3 && x[1] > 0.6; }, {0.0, 1.0, 0.5})};
    if (is_held) {
      TestConstraint held;
      held.given.components = {Expression(0.0), std::nullopt, Expression(0.0)};
      held.prescribed = [](const Point& x) { return x[0] < 0.3 && x[1] < 0.1; };
      constraints.push_back(held);
    }
    TiedBody body(
        comm, file,
        {1, make_law("neo-hookean", 1e6, 0.3), 1000.0, constraints, std::nullopt, Rigidity::of_accelerations});
    const ConstrainedMass mass{body.layout(), body.inertia(), body.potential().prescribed(), &body.map()};
    const auto projection = PartVelocityProjection::make(mass);
    ASSERT_NE(projection, nullptr);
    VelocityProjection whole(mass);
    // At rest but for the parts, whose velocities are affine, not rigid.
    const Handle<Vec> q = make_vector(body.layout()), wanted = make_vector(body.layout());
    {
      const ArrayView entries(wanted.get());
      for (const auto& dependent : body.map().dependents()) {
        for (const PetscInt a : dependent->nodes()) {
          const auto X = body.layout().position(a);
          const Point v = {0.3 + X[1] - 2.0 * X[2] + 0.1 * X[0], X[0] + 0.7 * X[1], 0.5 * X[2] - X[0] + X[1]};
          for (std::size_t i = 0; i < 3; ++i) entries[3 * a + static_cast<PetscInt>(i)] = v[i];
        }
      }
    }
    const Handle<Vec> v = make_vector(body.layout()), by_whole = make_vector(body.layout());
    (*projection)(q.get(), wanted.get(), v.get());
    whole(q.get(), wanted.get(), by_whole.get(), VelocityProjection::Scope::dependents);
    EXPECT_GT(test::norm(v.get()), 1.0);
    EXPECT_LT(test::distance(v.get(), by_whole.get()), 1e-12 * test::norm(v.get()));
  }
}

}  // namespace
}  // namespace pliant::test_part_velocity_projection
