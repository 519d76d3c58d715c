// How the neighbourhoods of nodes have turned.
#include "fem/body.hpp"
#include "fem/nodal_rotations.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"

namespace pliant::test_nodal_rotations {
namespace {

using test::Body;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

/// About the axis (1, 2, 2) / 3, by Rodrigues' formula.
Tensor3<double> rotation_by(double angle) {
  const Vector3<double> k = {1.0 / 3, 2.0 / 3, 2.0 / 3};
  const Tensor3<double> W{{0.0, -k[2], k[1], k[2], 0.0, -k[0], -k[1], k[0], 0.0}};
  return add_to_diagonal(std::sin(angle) * W + (1.0 - std::cos(angle)) * matmul(W, W), 1.0);
}

double largest_difference(const Tensor3<double>& A, const Tensor3<double>& B) {
  double largest = 0.0;
  for (std::size_t i = 0; i < 9; ++i) largest = std::max(largest, std::abs(A.a[i] - B.a[i]));
  return largest;
}

class Rotations : public ::testing::TestWithParam<int> {
 protected:
  Rotations()
      : file_(scratch_.file("body.msh",
                            [](const std::string& f) {
                              test::write_body(f, {1, Shape::jittered, 3});
                            })),
        body_(comm, file_, GetParam()),
        nothing_(3 * static_cast<std::size_t>(layout().num_local_nodes), 0) {}

  const NodeLayout& layout() const { return body_.layout; }
  /// The displacement that takes each node to `place` of its position.
  Handle<Vec> displacement(const std::function<Vector3<double>(const Point&)>& place) const {
    auto u = make_vector(layout());
    const ArrayView entries(u.get());
    for (PetscInt a = 0; a < layout().num_owned_nodes; ++a) {
      const auto X = layout().position(a);
      const auto x = place(X);
      for (int i = 0; i < 3; ++i) entries[3 * a + i] = x[static_cast<std::size_t>(i)] - X[static_cast<std::size_t>(i)];
    }
    return u;
  }
  Handle<Vec> turned(double angle) const {
    return displacement([&](const Point& X) {
      return matvec(rotation_by(angle), X) + Vector3<double>{1.0, -2.0, 3.0};
    });
  }
  /// Of all nodes, on all ranks.
  double error(const NodalRotations& rotations, const Tensor3<double>& exact) const {
    double largest = 0.0;
    for (PetscInt a = 0; a < layout().num_owned_nodes; ++a) {
      largest = std::max(largest, largest_difference(rotations[a], exact));
    }
    return maximum(comm, largest);
  }

  Scratch scratch_{comm};
  std::string file_;
  Body body_;
  std::vector<char> nothing_;
};

INSTANTIATE_TEST_SUITE_P(Orders, Rotations, ::testing::Values(1, 2),
                         [](const auto& of) { return "P" + std::to_string(of.param); });

// Newton's method ends at steps of 1e-3, and is then right to a part of the square of that.
TEST_P(Rotations, FollowABodyThatTurnsAndTurns) {
  NodalRotations rotations(layout(), nothing_);
  rotations.start(turned(0.5).get());
  EXPECT_EQ(error(rotations, identity<double>()), 0.0);
  for (const double angle : {0.6, 1.2, 2.0, 2.8, 3.6, 4.5, 5.4, 6.3, 7.0}) {
    rotations.follow(turned(angle).get());
    EXPECT_LE(error(rotations, rotation_by(angle - 0.5)), 1e-6) << angle;
  }
}

// A moderate stretch does not count, but for the part that a moment matrix of a neighbourhood on one side of its node
// mixes in.
TEST_P(Rotations, AreNearThoseOfAStretchedBody) {
  NodalRotations rotations(layout(), nothing_);
  rotations.start(turned(0.0).get());
  rotations.follow(displacement([&](const Point& X) {
                     return matvec(rotation_by(0.8), Vector3<double>{1.1 * X[0], X[1], 0.95 * X[2]});
                   }).get());
  EXPECT_LE(error(rotations, rotation_by(0.8)), 0.05);
}

TEST_P(Rotations, OfAFlattenedBodyAreRotations) {
  NodalRotations rotations(layout(), nothing_);
  rotations.start(turned(0.0).get());
  rotations.follow(displacement([&](const Point& X) { return Vector3<double>{X[0], 0.0, -X[2]}; }).get());
  for (PetscInt a = 0; a < layout().num_owned_nodes; ++a) {
    EXPECT_LE(largest_difference(matmul(transpose(rotations[a]), rotations[a]), identity<double>()), 1e-12);
    EXPECT_GT(det(rotations[a]), 0.0);
  }
}

TEST_P(Rotations, TurnVectorsThereAndBackButNotSupports) {
  std::vector<char> prescribed = nothing_;
  prescribed[1] = 1;  // of the first node, one component
  NodalRotations rotations(layout(), prescribed);
  rotations.start(turned(0.0).get());
  rotations.follow(turned(1.0).get());
  const auto x = displacement([](const Point& X) { return 2.0 * X; });
  Handle<Vec> y;
  check(VecDuplicate(x.get(), y.out()));
  check(VecCopy(x.get(), y.get()));
  rotations.turn(y.get());
  const auto Q = rotation_by(1.0);
  {
    const ConstArrayView before(x.get()), after(y.get());
    for (PetscInt a = 0; a < layout().num_owned_nodes; ++a) {
      const Vector3<double> from = {before[3 * a], before[3 * a + 1], before[3 * a + 2]};
      const auto to = a == 0 ? from : matvec(Q, from);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(after[3 * a + i], to[static_cast<std::size_t>(i)], 1e-6);
    }
  }
  rotations.turn_back(y.get());
  check(VecAXPY(y.get(), -1.0, x.get()));
  PetscReal rest = 0.0;
  check(VecNorm(y.get(), NORM_INFINITY, &rest));
  EXPECT_LE(rest, 1e-13);
}

}  // namespace
}  // namespace pliant::test_nodal_rotations
