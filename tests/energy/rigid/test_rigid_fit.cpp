// The rigid motion that is nearest to that of some nodes.
#include "energy/rigid/affine_fit.hpp"
#include "energy/rigid/rigid_fit.hpp"
#include "energy/solid.hpp"
#include "fem/selection.hpp"

#include <cmath>

namespace pliant::test_rigid_fit {
namespace {

using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

class RigidFit : public ::testing::Test {
 protected:
  std::vector<PetscInt> nodes(const Region& region) const { return nodes_in_region(solid_.layout(), region); }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) {
    test::write_body(f, {1, Shape::jittered, 3});
  });
  Solid solid_{comm, file_, 1, 1};
  Region side_ = [](const Point& x) { return x[0] > 1.0 - 1e-9; };
  Point centre_{0.3, 0.2, -0.5};
};

TEST_F(RigidFit, FindsRigidMotionsOfAnySize) {
  const Point translation{0.4, -2.0, 0.1};
  for (const double angle : {0.0, 1e-7, 0.5, 2.0, 3.1}) {
    const Vector3<double> theta = angle * Vector3<double>{0.36, -0.48, 0.8};
    const Placement exact{translation, exponential(theta)};
    const auto u = solid_.vector([&](const Point& x) { return exact.displacement(x - centre_); });
    for (const bool is_about_axis : {false, true}) {
      const auto found =
          is_about_axis ? nearest_placement_about({0.36, -0.48, 0.8}, solid_.layout(), nodes(side_), centre_, u.get())
                        : nearest_placement(solid_.layout(), nodes(side_), centre_, u.get());
      for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(found.translation[i], translation[i], 1e-14);
        // The translation is five times the size of the nodes' arms, and so is its rounding.
        EXPECT_NEAR(logarithm(found.rotation)[i], theta[i], 1e-14 * (1.0 + angle));
      }
    }
  }
}

// The nearest one: no other is nearer.
TEST_F(RigidFit, IsTheNearest) {
  const auto chosen = nodes(side_);
  const auto u = solid_.vector([](const Point& x) {
    const Point w = test::strained(x);
    return w + turn(Vector3<double>{0.3, 0.9, -0.5}, x) - x;
  });
  const auto squares = [&](const Placement& at) {
    const ConstArrayView v(u.get());
    double total = 0.0;
    for (const PetscInt a : chosen) {
      const auto rigid = at.displacement(solid_.layout().position(a) - centre_);
      for (int i = 0; i < 3; ++i) total += std::pow(rigid[i] - v[3 * a + i], 2);
    }
    return sum(comm, total);
  };
  const auto found = nearest_placement(solid_.layout(), chosen, centre_, u.get());
  const double least = squares(found), h = 1e-3;
  ASSERT_GT(least, 1e-4);
  for (std::size_t k = 0; k < 3; ++k) {
    for (const double s : {-h, h}) {
      Placement other = found;
      other.translation[k] += s;
      EXPECT_GT(squares(other), least);
      other = found;
      Vector3<double> theta{};
      theta[k] = s;
      other.rotation = product(exponential(theta), found.rotation);
      EXPECT_GT(squares(other), least);
    }
  }
}

// What is affine is found again: of a volume, of a side but for what lies across it, and across an axis.
TEST_F(RigidFit, FindsAffineMotions) {
  const Tensor3<double> D{{0.3, -0.8, 0.1, 0.9, -0.2, 0.4, -0.5, 0.6, 0.7}};
  const Point translation{0.4, -2.0, 0.1}, axis{0.36, -0.48, 0.8};
  const auto u = solid_.vector([&](const Point& x) { return translation + matvec(D, x - centre_); });
  const auto all = nodes([](const Point&) { return true; });
  const auto volume = AffineFit(solid_.layout(), all, centre_)(solid_.layout(), all, u.get());
  const Point on_side{1.0, 0.2, -0.5};
  const auto side = AffineFit(solid_.layout(), nodes(side_), on_side)(solid_.layout(), nodes(side_), u.get());
  const auto moved = translation + matvec(D, on_side - centre_);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(volume.translation[k], translation[k], 1e-13);
    EXPECT_NEAR(side.translation[k], moved[k], 1e-13);
    for (int j = 0; j < 3; ++j) {
      EXPECT_NEAR(volume.gradient(i, j), D(i, j), 1e-13);
      EXPECT_NEAR(side.gradient(i, j), j == 0 ? 0.0 : D(i, j), 1e-13);
    }
  }
  const auto w = solid_.vector([&](const Point& x) {
    const Point r = x - centre_;
    return translation + 0.7 * cross(axis, r) - 0.2 * (r - dot(axis, r) * axis);
  });
  const auto edge = nodes([](const Point& x) { return x[0] < 1e-9 && x[1] < 1e-9; });
  const auto turned = AffineFit(solid_.layout(), edge, centre_, axis)(solid_.layout(), edge, w.get());
  const Point r{-0.4, 0.5, 0.9}, expected = 0.7 * cross(axis, r) - 0.2 * (r - dot(axis, r) * axis);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(turned.translation[i], translation[i], 1e-13);
    EXPECT_NEAR(matvec(turned.gradient, r)[i], expected[i], 1e-13);
  }
}

}  // namespace
}  // namespace pliant::test_rigid_fit
