#include "energy/solid.hpp"
#include "energy/volume/step_bound.hpp"
#include "material/states.hpp"

namespace pliant::test_step_bound {
namespace {

using test::Point;
using test::Scratch;
using test::Solid;
using test::TestStage;
using testing_states::Matrix;

const Matrix unit = identity<double>();

Matrix diagonal(double a, double b, double c) {
  return {{a, 0, 0, 0, b, 0, 0, 0, c}};
}

TEST(FirstInversion, IsTheSmallestRootOfTheDeterminant) {
  EXPECT_NEAR(first_inversion(unit, diagonal(-2, 0, 0)), 0.5, 1e-12);          // one simple root
  EXPECT_NEAR(first_inversion(unit, diagonal(-1.25, -5, 0)), 0.2, 1e-12);      // the first of two
  EXPECT_NEAR(first_inversion(unit, diagonal(-1.25, -1.6, -4)), 0.25, 1e-12);  // of three
  EXPECT_NEAR(first_inversion(unit, diagonal(-2, -2, 0)), 0.5, 1e-6);          // a double one: touches zero
  EXPECT_NEAR(first_inversion(unit, diagonal(-2, -2, -2)), 0.5, 1e-5);         // a triple one
  EXPECT_NEAR(first_inversion(unit, diagonal(-1, 0, 0)), 1.0, 1e-12);          // at the very end
  EXPECT_NEAR(first_inversion(unit, diagonal(-1e12, 0, 0)), 1e-12, 1e-23);     // at once
  EXPECT_EQ(first_inversion(unit, diagonal(-0.99, 0, 0)), HUGE_VAL);
  EXPECT_EQ(first_inversion(unit, diagonal(5, 3, 1)), HUGE_VAL);
  EXPECT_EQ(first_inversion(unit, Matrix{}), HUGE_VAL);
}

// Half a turn by the straight path goes through the flat state, a quarter does not.
TEST(FirstInversion, OfStraightPathsToRotatedStates) {
  const Matrix half_turn = diagonal(-1, -1, 1);
  EXPECT_NEAR(first_inversion(unit, half_turn - unit), 0.5, 1e-6);
  EXPECT_EQ(first_inversion(unit, testing_states::rotation(0.0, 0.0, 1.57) - unit), HUGE_VAL);
}

// Against a fine walk along the path; and the quick check never misses an inversion.
TEST(FirstInversion, AgreesWithAWalkAndIsNeverMissed) {
  int inverting = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    const Matrix F = unit + testing_states::random_matrix(seed, 0.2);
    const Matrix dF = testing_states::random_matrix(seed + 1000, 1.5);
    double walked = HUGE_VAL;
    constexpr int steps = 20000;
    for (int i = 1; i <= steps && walked == HUGE_VAL; ++i) {
      const double alpha = static_cast<double>(i) / steps;
      if (det(F + alpha * dF) <= 0.0) walked = alpha;
    }
    const double found = first_inversion(F, dF);
    if (walked == HUGE_VAL) {
      EXPECT_EQ(found, HUGE_VAL);
      continue;
    }
    ++inverting;
    EXPECT_LE(found, walked + 1e-9);
    EXPECT_GE(found, walked - 1.0 / steps - 1e-9);
    const auto packed = [](const Matrix& A) { return make_tensor([&](int i, int j) { return Pack(A(i, j)); }); };
    EXPECT_TRUE(may_invert(packed(F), packed(dF)));
  }
  EXPECT_GT(inverting, 50);
  EXPECT_LT(inverting, 200);
}

TEST(MayInvert, IsFalseForSmallSteps) {
  const auto packed = [](const Matrix& A) { return make_tensor([&](int i, int j) { return Pack(A(i, j)); }); };
  EXPECT_FALSE(may_invert(packed(unit), packed(testing_states::random_matrix(1, 0.05))));
}

// One tetrahedron whose apex falls through its base: flat at 1 / 1.6 of the way, for each law with a barrier.
TEST(StepBound, OfASingleTetrahedronIsExact) {
  const Scratch scratch(MPI_COMM_WORLD);
  const auto file =
      scratch.text("tet.msh",
                   "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 2 0 0\n3 0 1 0\n4 0.3 0.3 0.5\n"
                   "$EndNodes\n$Elements\n1\n1 4 2 0 1 1 2 3 4\n$EndElements\n");
  for (const int order : {1, 2}) {
    for (const auto& law : test::every_law()) {
      const Solid solid(MPI_COMM_SELF, file, order, elastic_quadrature_degree(law.traits(), order));
      const auto term = solid.elastic(law);
      const auto q = test::local_values(solid.vector(test::at_rest).get());
      // Affine, so that P2's middles follow.
      const auto d = test::local_values(solid.vector([](const Point& x) {
                                               return Point{0.2 * x[2], 0.0, -1.6 * x[2]};
                                             })
                                            .get());
      const double bound = term->max_step({}, q, d);
      if (test::is_barrier(law)) {
        EXPECT_NEAR(bound, 1.0 / 1.6, 1e-11);
      } else {
        EXPECT_EQ(bound, HUGE_VAL);
      }
    }
  }
}

}  // namespace
}  // namespace pliant::test_step_bound
