// Which nodes can be a rigid part that rotates freely. Its motion: test_constrained_equation.cpp.
#include "energy/constraint/rigid_part.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"

namespace pliant::test_rigid_part {
namespace {

using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

TEST(RigidPart, NeedsNodesThatDetermineItsRotation) {
  const Scratch scratch(comm);
  const std::string file = scratch.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 3});
  });
  const Solid solid(comm, file, 1, 1);
  const NodeLayout& layout = solid.layout();
  const auto corner = nodes_in_region(layout, [](const Point& x) { return dot(x, x) < 1e-12; });
  const auto edge = nodes_in_region(layout, [](const Point& x) { return x[0] < 1e-9 && x[1] < 1e-9; });
  const auto side = nodes_in_region(layout, [](const Point& x) { return x[0] > 1.0 - 1e-9; });
  RigidMotion motion;
  motion.axis = {0.0, 0.0, 1.0};
  EXPECT_TRUE(why_not_rigid(layout, corner, motion, FreeRotation::about_all_axes).has_value());
  EXPECT_TRUE(why_not_rigid(layout, edge, motion, FreeRotation::about_all_axes).has_value());
  EXPECT_TRUE(why_not_rigid(layout, edge, motion, FreeRotation::about_axis).has_value());
  EXPECT_FALSE(why_not_rigid(layout, side, motion, FreeRotation::about_all_axes).has_value());
  motion.axis = {1.0, 0.0, 0.0};
  EXPECT_FALSE(why_not_rigid(layout, edge, motion, FreeRotation::about_axis).has_value());
}

}  // namespace
}  // namespace pliant::test_rigid_part
