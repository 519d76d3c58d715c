// Bodies that meet, by a term whose pairs change from one evaluation to the next: the same motion on every number of
// ranks, and factorizations that outlive changes of the matrix's pattern.
#include "energy/near_springs.hpp"
#include "petsc/collective.hpp"
#include "solver/problem.hpp"

#include <ostream>
#include <set>

namespace pliant::test_changing_pairs {
namespace {

using test::NearSprings;
using test::Point;
using test::Problem;
using test::ProblemSpec;
using test::Scratch;
using test::Solid;

constexpr double gap = 0.5, reach = 0.45, between = 1.0 + 0.5 * gap, dt = 0.008;
constexpr int num_steps = 50;

struct Case {
  int order;
  LinearKind linear;
};
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << "P" << c.order << " " << static_cast<int>(c.linear);
}

class ChangingPairs : public ::testing::TestWithParam<Case> {
 protected:
  ProblemSpec spec() const {
    ProblemSpec result;
    result.order = GetParam().order;
    result.linear = GetParam().linear;
    result.law = test::every_law()[0];
    result.density = 10.0;
    result.loads = [](const Solid& solid) {
      std::vector<std::unique_ptr<EnergyTerm>> terms;
      terms.push_back(std::make_unique<NearSprings>(solid.layout(), between, 30.0, reach));
      return terms;
    };
    return result;
  }

  Scratch scratch_{MPI_COMM_WORLD};
  std::string file_ =
      scratch_.file("two.msh", [](const std::string& f) { test::write_two_cubes(f, gap, 3 - GetParam().order); });
};

INSTANTIATE_TEST_SUITE_P(Solvers, ChangingPairs,
                         ::testing::Values(Case{1, LinearKind::cholesky}, Case{1, LinearKind::amg},
                                           Case{2, LinearKind::cholesky}, Case{2, LinearKind::p_multigrid}));

/// The second body flies towards the first, and past its corner.
Point thrown(const Point& x) {
  return x[0] > between ? Point{-2.0, 0.7, 0.3} : Point{};
}

/// Pairs of nodes nearer than the reach, by comparing all; of a body that is on one rank.
std::set<std::pair<PetscInt, PetscInt>> pairs_at(const NodeLayout& layout, std::span<const double> q) {
  std::set<std::pair<PetscInt, PetscInt>> pairs;
  for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
    for (PetscInt b = 0; b < layout.num_owned_nodes; ++b) {
      if (layout.position(a)[0] > between || layout.position(b)[0] < between) continue;
      double squares = 0.0;
      for (int i = 0; i < 3; ++i) {
        squares += std::pow(layout.position(a)[i] + q[3 * a + i] - layout.position(b)[i] - q[3 * b + i], 2);
      }
      if (squares < reach * reach) pairs.insert({a, b});
    }
  }
  return pairs;
}

/// What can be compared between ranks, after each step.
struct Motion {
  std::vector<double> numbers;
  int num_changes = 0;  // of the set of pairs, where the body is on one rank
};

Motion move(Problem& problem) {
  const Solid& solid = problem.solid();
  Handle<Vec> q0 = solid.vector(test::at_rest), v = solid.vector(thrown), q = solid.vector(test::at_rest);
  const Handle<Vec> weights = solid.vector(test::rough_field(1.0, 3));
  Motion motion;
  std::set<std::pair<PetscInt, PetscInt>> pairs;
  for (int step = 1; step <= num_steps; ++step) {
    const StageReport report = problem.solve(step * dt, dt, q0, v, q);
    EXPECT_EQ(report.outcome, StageOutcome::converged) << step << " " << report.reason;
    check(VecWAXPY(v.get(), -1.0, q0.get(), q.get()));
    check(VecScale(v.get(), 1.0 / dt));
    check(VecCopy(q.get(), q0.get()));
    motion.numbers.push_back(test::norm(q.get()));
    motion.numbers.push_back(test::dot(q.get(), weights.get()));
    if (solid.layout().num_owned_nodes != solid.layout().num_global_nodes) continue;
    const auto now = pairs_at(solid.layout(), test::local_values(q.get()));
    if (now != pairs) ++motion.num_changes;
    pairs = now;
  }
  return motion;
}

TEST_P(ChangingPairs, GiveTheSameMotionOnAnyRanksWithKeptFactors) {
  Problem many(MPI_COMM_WORLD, file_, spec()), alone(MPI_COMM_SELF, file_, spec());
  const Motion here = move(many), there = move(alone);
  for (std::size_t i = 0; i < here.numbers.size(); ++i) {
    EXPECT_NEAR(here.numbers[i], there.numbers[i], 1e-7 * std::abs(there.numbers[i])) << i;
  }
  EXPECT_GE(there.num_changes, 5);
  for (const Problem* problem : {&many, &alone}) {
    EXPECT_LE(2 * problem->statistics().factorizations, there.num_changes);
    EXPECT_LT(3 * problem->statistics().factorizations, problem->statistics().newton_iterations);
  }
}

}  // namespace
}  // namespace pliant::test_changing_pairs
