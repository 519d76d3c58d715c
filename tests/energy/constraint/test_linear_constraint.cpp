// Elimination of linear constraints: chains, what is implied, what contradicts, and how it is told.
#include "energy/constraint/linear_constraint.hpp"
#include "petsc/session.hpp"

#include <gtest/gtest.h>

namespace pliant::test_linear_constraint {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;
constexpr std::array times{0.0, 0.3, 1.0};

GivenDisplacement along_x(const std::string& formula) {
  return {{Expression(formula), std::nullopt, std::nullopt}};
}

/// sum c q = the given displacement of the source, in x.
LinearConstraint constraint(std::vector<ConstraintEntry> entries, std::size_t source) {
  return {std::move(entries), {{1.0, source, 0, {}}}, source};
}

/// The entry's value at a time when free entries have the values of `y`.
double value(const Elimination& e, const std::vector<GivenDisplacement>& given, PetscInt entry,
             const std::vector<double>& y, double t) {
  for (const Slave& slave : e.slaves) {
    if (slave.entry != entry) continue;
    double sum = 0.0;
    for (const auto& m : slave.masters) sum += m.coefficient * y[static_cast<std::size_t>(m.entry)];
    for (const auto& g : slave.given) sum += g.weight * given[g.source](g.component, g.X, t);
    return sum;
  }
  return y[static_cast<std::size_t>(entry)];
}

const std::vector<double> y{0.3, -1.1, 0.7, 2.0, -0.4, 0.9};

TEST(Elimination, FulfilsEveryConstraintOfAChain) {
  // Later constraints name slaves of earlier ones, and make slaves of their masters.
  const std::vector<GivenDisplacement> given{along_x("t"), along_x("2+t^2"), along_x("-1"), along_x("0.5*t")};
  const std::vector<LinearConstraint> constraints{
      constraint({{0, 1.0}, {1, -2.0}, {2, 0.5}}, 0), constraint({{3, 4.0}, {1, 1.0}, {0, 1.0}}, 1),
      constraint({{3, 1.0}, {2, -1.0}, {4, 1.0}}, 2), constraint({{5, -2.0}}, 3)};
  const auto result = eliminate(constraints, given, times);
  EXPECT_TRUE(result.conflicts.empty());
  ASSERT_EQ(result.slaves.size(), 4u);
  for (const Slave& slave : result.slaves) {
    for (const auto& master : slave.masters) {
      for (const Slave& other : result.slaves) EXPECT_NE(master.entry, other.entry) << "a master is a slave";
    }
  }
  for (const double t : times) {
    for (const auto& c : constraints) {
      double left = 0.0;
      for (const auto& e : c.entries) left += e.coefficient * value(result, given, e.entry, y, t);
      EXPECT_NEAR(left, given[c.source](0, {}, t), 1e-14);
    }
  }
}

TEST(Elimination, TakesThePreferredSlaveUnlessItsCoefficientIsSmall) {
  const std::vector<GivenDisplacement> given{along_x("0")};
  for (const auto& [coefficient, slave] : {std::pair{0.5, 0}, {0.01, 1}}) {
    Eliminator eliminator(given, times);
    eliminator.add({{{0, coefficient}, {1, -1.2}, {2, 0.3}}, {}, 0}, 0);
    ASSERT_NE(eliminator.find(slave), nullptr);
    EXPECT_EQ(eliminator.find(1 - slave), nullptr);
    const Elimination result = std::move(eliminator).take();
    ASSERT_EQ(result.slaves.size(), 1u);
    const double left = coefficient * value(result, given, 0, y, 0.0) - 1.2 * value(result, given, 1, y, 0.0) +
                        0.3 * value(result, given, 2, y, 0.0);
    EXPECT_NEAR(left, 0.0, 1e-14);
  }
}

// The corner of a cell that is periodic in two directions is reached on two ways.
TEST(Elimination, DropsWhatIsImplied) {
  const std::vector<GivenDisplacement> given{along_x("t"), along_x("3*t")};
  const std::vector<LinearConstraint> constraints{
      constraint({{1, 1.0}, {0, -1.0}}, 0), constraint({{3, 1.0}, {2, -1.0}}, 0), constraint({{2, 1.0}, {0, -1.0}}, 1),
      constraint({{3, 1.0}, {1, -1.0}}, 1)};
  const auto result = eliminate(constraints, given, times);
  EXPECT_TRUE(result.conflicts.empty());
  EXPECT_EQ(result.slaves.size(), 3u);
  EXPECT_NEAR(value(result, given, 3, y, 0.5) - y[0], 2.0, 1e-15);
}

TEST(Elimination, TellsWhoContradictsWhom) {
  const std::vector<GivenDisplacement> given{along_x("0"), along_x("0*t"), along_x("t*(t-1)")};
  const std::vector<LinearConstraint> constraints{constraint({{0, 1.0}}, 0), constraint({{1, 1.0}, {0, -1.0}}, 1),
                                                  constraint({{1, 2.0}}, 2)};
  // 0 at the start and at the end, but not in between.
  EXPECT_TRUE(eliminate(constraints, given, std::array{0.0, 1.0}).conflicts.empty());
  const auto result = eliminate(constraints, given, times);
  ASSERT_EQ(result.conflicts.size(), 1u);
  EXPECT_EQ(result.conflicts[0], std::pair(std::size_t{1}, std::size_t{2}));
}

TEST(Elimination, TakesTheLargestCoefficientAndTheFirstOfEqualOnes) {
  const std::vector<GivenDisplacement> given{along_x("0")};
  EXPECT_EQ(eliminate(std::vector{constraint({{4, 0.6}, {5, -0.8}}, 0)}, given, times).slaves[0].entry, 5);
  EXPECT_EQ(eliminate(std::vector{constraint({{5, -1.0}, {4, 1.0}}, 0)}, given, times).slaves[0].entry, 5);
}

TEST(LinearConstraints, AreGatheredAsTheyAre) {
  const auto r = static_cast<PetscInt>(rank(comm));
  const std::vector<LinearConstraint> mine{
      {{{3 * r, 0.1}, {3 * r + 1, -1.0 / 3.0}}, {{2.5, 1, 2, {0.1, 0.2, 0.3}}}, static_cast<std::size_t>(r)}, {}};
  const auto all = gathered(comm, mine);
  ASSERT_EQ(all.size(), 2 * static_cast<std::size_t>(num_ranks(comm)));
  for (PetscInt k = 0; k < num_ranks(comm); ++k) {
    const auto& c = all[2 * static_cast<std::size_t>(k)];
    ASSERT_EQ(c.entries.size(), 2u);
    EXPECT_EQ(c.entries[1].entry, 3 * k + 1);
    EXPECT_EQ(c.entries[1].coefficient, -1.0 / 3.0);
    ASSERT_EQ(c.given.size(), 1u);
    EXPECT_EQ(c.given[0].component, 2);
    EXPECT_EQ(c.given[0].X, (Vector3<double>{0.1, 0.2, 0.3}));
    EXPECT_EQ(c.source, static_cast<std::size_t>(k));
  }
}

}  // namespace
}  // namespace pliant::test_linear_constraint
