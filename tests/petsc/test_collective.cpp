#include "base/error.hpp"
#include "petsc/check.hpp"
#include "petsc/collective.hpp"
#include "petsc/handle.hpp"
#include "petsc/session.hpp"

#include <gtest/gtest.h>

namespace pliant::test_collective {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

TEST(Collective, InputErrorOfRootReachesEveryRankWhole) {
  try {
    on_root(comm, [] {
      throw InputError({{Severity::error, {"a.yaml", 3, 7}, "unknown key 'x'\nsecond line"},
                        {Severity::error, {"", 0, 0}, "no place"}});
    });
    FAIL() << "no exception";
  } catch (const InputError& e) {
    ASSERT_EQ(e.diagnostics().size(), 2u);
    EXPECT_EQ(e.diagnostics()[0].where.line, 3);
    EXPECT_EQ(e.diagnostics()[0].message, "unknown key 'x'\nsecond line");
    EXPECT_STREQ(e.what(), "a.yaml:3:7: unknown key 'x'\nsecond line\nno place");
  }
}

TEST(Collective, FailureOfTheLastRankReachesEveryRank) {
  const int last = num_ranks(comm) - 1;
  EXPECT_THROW(on_every_rank(comm,
                             [&] {
                               if (rank(comm) == last) throw FileError("disk full");
                             }),
               FileError);
  EXPECT_NO_THROW(on_every_rank(comm, [] {}));
}

TEST(Collective, BroadcastAndReductions) {
  EXPECT_EQ(broadcast(comm, rank(comm) == 0 ? "text of root" : ""), "text of root");
  const int n = num_ranks(comm);
  EXPECT_DOUBLE_EQ(sum(comm, 1.0 + rank(comm)), n * (n + 1) / 2.0);
  EXPECT_DOUBLE_EQ(maximum(comm, rank(comm)), n - 1);
  EXPECT_TRUE(any_rank(comm, rank(comm) == n - 1));
}

TEST(Collective, ListsAreGatheredRankByRank) {
  // Rank r gives r numbers: none on the first.
  const std::vector<double> mine(static_cast<std::size_t>(rank(comm)), rank(comm));
  std::vector<double> expected;
  for (int r = 0; r < num_ranks(comm); ++r) expected.insert(expected.end(), static_cast<std::size_t>(r), r);
  EXPECT_EQ(gathered(comm, mine), expected);
}

TEST(Collective, StructsAreGatheredRankByRank) {
  struct Row {
    std::int64_t large;
    char small;
    bool operator==(const Row&) const = default;
  };
  const auto row = [](int r) { return Row{(std::int64_t{1} << 60) + r, static_cast<char>('a' + r)}; };
  const std::vector<Row> mine(static_cast<std::size_t>(rank(comm) + 1), row(rank(comm)));
  std::vector<Row> expected;
  for (int r = 0; r < num_ranks(comm); ++r) expected.insert(expected.end(), static_cast<std::size_t>(r + 1), row(r));
  EXPECT_TRUE(gathered(comm, mine) == expected);
}

TEST(Check, NamesThePlaceAndThrows) {
  try {
    check(PETSC_ERR_ARG_SIZ);
    FAIL();
  } catch (const PetscFailure& e) {
    EXPECT_NE(std::string(e.what()).find("test_collective.cpp"), std::string::npos);
    EXPECT_EQ(e.code(), PETSC_ERR_ARG_SIZ);
  }
}

TEST(Handle, ShareKeepsTheObjectAlive) {
  Handle<Vec> v;
  check(VecCreateMPI(comm, 2, PETSC_DECIDE, v.out()));
  Handle<Vec> second = v.share();
  v = Handle<Vec>();
  check(VecSet(second.get(), 1.0));
  PetscReal norm = 0;
  check(VecNorm(second.get(), NORM_1, &norm));
  EXPECT_DOUBLE_EQ(norm, 2.0 * num_ranks(comm));
}

}  // namespace
}  // namespace pliant::test_collective
