#include "base/limits.hpp"
#include "collision/mollifier.hpp"
#include "collision/potential.hpp"
#include "derivatives.hpp"
#include "laws.hpp"

#include <eigen3/Eigen/Eigenvalues>
#include <map>

#include <gtest/gtest.h>

namespace pliant::test_potential {
namespace {

using namespace testing_collision;
using Law = Response (*)(double);

template <int N>
Expansion<N> potential(const Stencil<N>& stencil, const Points<N>& x, Law law, Definiteness definiteness) {
  const auto at = separation<N>(stencil, x);
  return expand(at, law(at.distance), definiteness);
}
Expansion<4> point_triangle(const Points<4>& x, Law law, Definiteness definiteness = Definiteness::exact) {
  return potential<4>(stencil_of(closest_point_triangle(x)), x, law, definiteness);
}
Expansion<4> edge_edge(const Points<4>& x, Law law, Definiteness definiteness = Definiteness::exact) {
  return potential<4>(stencil_of(closest_edge_edge(x)), x, law, definiteness);
}
int feature_of_triangle(const Points<4>& x) {
  return static_cast<int>(closest_point_triangle(x).feature);
}
int feature_of_edges(const Points<4>& x) {
  const EdgeEdge closest = closest_edge_edge(x);
  return 3 * static_cast<int>(closest.a) + static_cast<int>(closest.b);
}

template <int N>
Eigen::Matrix<double, 3 * N, 3 * N> matrix(const Expansion<N>& f) {
  Eigen::Matrix<double, 3 * N, 3 * N> K;
  for (int i = 0; i < 3 * N; ++i) {
    for (int j = 0; j < 3 * N; ++j) K(i, j) = f.block(i / 3, j / 3)(i % 3, j % 3);
  }
  return K;
}

/// Distances of .05 to .95, at every feature.
template <class Use>
void over_configurations(const Use& use) {
  RandomPoints random(1);
  for (int trial = 0; trial < 6000; ++trial) {
    auto x = random.points<4>();
    if (trial % 2 == 0) x[0] = (1.0 / 3) * (x[1] + x[2] + x[3]) + random.point(0.4);
    use(trial, x);
  }
}

template <class F, class Feature>
void expect_derivatives(const F& f, const Feature& feature_of, std::size_t num_features) {
  constexpr double step = 1e-6;
  std::map<int, int> compared;
  over_configurations([&](int trial, const Points<4>& x) {
    const auto at = f(x);
    // Not at edges that are nearly parallel, nor where nothing is felt.
    if (at.value < 1e-3 || at.value > 5.0 || size_of_hessian(at) > 300.0) return;
    const int feature = feature_of(x);
    bool is_inside = true;
    for (int i = 0; i < 12; ++i) {
      for (const double sign : {-2.0, 2.0}) {
        Points<4> moved = x;
        moved[i / 3][i % 3] += sign * step;
        is_inside = is_inside && feature_of(moved) == feature;
      }
    }
    if (!is_inside) return;
    const DerivativeErrors errors = compare_with_differences<4>(f, x, step);
    EXPECT_LT(errors.gradient, 1e-6) << "trial " << trial << ", feature " << feature;
    EXPECT_LT(errors.hessian, 1e-5) << "trial " << trial << ", feature " << feature;
    ++compared[feature];
  });
  EXPECT_EQ(compared.size(), num_features);
}

TEST(Potential, DerivativesOfAPointAndATriangle) {
  for (const Law law : {barrier, penalty}) {
    expect_derivatives([&](const Points<4>& x) { return point_triangle(x, law); }, feature_of_triangle, 7);
  }
}
TEST(Potential, DerivativesOfTwoEdges) {
  for (const Law law : {barrier, penalty}) {
    expect_derivatives([&](const Points<4>& x) { return edge_edge(x, law); }, feature_of_edges, 9);
  }
}

/// The projection by the form of the Hessian is that of all its eigenvalues.
TEST(Potential, SemidefiniteHessianIsTheNearest) {
  std::map<int, int> changed;
  over_configurations([&](int trial, const Points<4>& x) {
    for (const bool of_edges : {false, true}) {
      const auto f = [&](Definiteness definiteness) {
        return of_edges ? edge_edge(x, penalty, definiteness) : point_triangle(x, penalty, definiteness);
      };
      Expansion<4> full = f(Definiteness::exact);
      const Expansion<4> exact = full, fast = f(Definiteness::semidefinite);
      const double size = size_of_hessian(exact);
      if (exact.value == 0.0 || size > 1e4) continue;
      project_to_positive_semidefinite(full);
      for (std::size_t n = 0; n < 16; ++n) {
        for (std::size_t p = 0; p < 9; ++p) {
          EXPECT_NEAR(fast.blocks[n].a[p], full.blocks[n].a[p], 1e-11 * size) << "trial " << trial;
        }
      }
      const auto K = matrix(fast);
      EXPECT_GE(K.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), -1e-12 * size) << "trial " << trial;
      const int feature = of_edges ? 10 + feature_of_edges(x) : feature_of_triangle(x);
      if ((matrix(exact) - K).norm() > 1e-6 * size) ++changed[feature];
    }
  });
  EXPECT_EQ(changed.size(), 16U);  // every feature bends
}

TEST(Potential, SemidefiniteHessianOfACombinedPoint) {
  RandomPoints random(3);
  int compared = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const auto x = random.points<6>();
    const Points<4> simple{{0.5 * x[0] + 0.25 * x[1] + 0.25 * x[2], x[3], x[4], x[5]}};
    const auto stencil = stencil_of<3>({0.5, 0.25, 0.25}, closest_point_triangle(simple));
    const auto exact = matrix(potential<6>(stencil, x, barrier, Definiteness::exact));
    const auto projected = matrix(potential<6>(stencil, x, barrier, Definiteness::semidefinite));
    const double size = exact.norm();
    if (size == 0.0 || size > 1e4) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 18, 18>> solver(exact);
    const Eigen::Matrix<double, 18, 18> nearest =
        solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose();
    EXPECT_LT((projected - nearest).norm(), 1e-11 * size) << "trial " << trial;
    ++compared;
  }
  EXPECT_GT(compared, 100);
}

TEST(Potential, ProductHasTheDerivativesOfMollifiedEdges) {
  constexpr double threshold = 0.3;
  const auto f = [&](const Points<4>& x) { return product(edge_edge_mollifier(x, threshold), edge_edge(x, barrier)); };
  int compared = 0;
  over_configurations([&](int trial, const Points<4>& x) {
    const Expansion<4> at = f(x);
    const double m = edge_edge_mollifier_value(x, threshold);
    if (m > 0.99 || m < 0.01 || at.value < 1e-4 || size_of_hessian(at) > 300.0) return;
    const DerivativeErrors errors = compare_with_differences<4>(f, x, 1e-6);
    EXPECT_LT(errors.gradient, 1e-5) << "trial " << trial;
    compared += errors.hessian < 1e-5 ? 1 : 0;  // not across two features
  });
  EXPECT_GT(compared, 300);
}

/// C2 at parallel edges: the Hessian of m U goes to zero, though that of U grows without bound.
TEST(Potential, MollifiedHessianVanishesAtParallelEdges) {
  double previous = infinity;
  for (const double angle : {1e-2, 1e-3, 1e-4}) {
    const Points<4> x{{{-1, 0, 0}, {1, 0, 0}, {-1, -angle, 0.5}, {1, angle, 0.5}}};
    const Expansion<4> U = edge_edge(x, barrier), f = product(edge_edge_mollifier(x, mollifier_threshold(x)), U);
    EXPECT_GT(size_of_hessian(U), 0.01 / (angle * angle));
    EXPECT_LT(size_of_hessian(f), 1e-3 * previous);
    previous = size_of_hessian(f);
  }
}

TEST(Potential, ProjectionLeavesTheDefiniteAlone) {
  Expansion<4> f;
  for (int i = 0; i < 4; ++i) f.block(i, i) = identity<double>();
  const auto before = f.blocks;
  project_to_positive_semidefinite(f);
  for (std::size_t n = 0; n < 16; ++n) EXPECT_EQ(f.blocks[n].a, before[n].a);
}

}  // namespace
}  // namespace pliant::test_potential
