// Linear functions among the quadratic ones.
#include "fem/block_matrix.hpp"
#include "fem/body.hpp"
#include "fem/coarsening.hpp"
#include "petsc/array_view.hpp"

namespace pliant::test_coarsening {
namespace {

using test::Body;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

class Coarsenings : public ::testing::Test {
 protected:
  Coarsenings()
      : file_(scratch_.file("body.msh",
                            [](const std::string& f) {
                              test::write_body(f, {2, Shape::jittered, 3});
                            })),
        body_(comm, file_, 2) {}

  const NodeLayout& layout() const { return body_.layout; }
  /// P x.
  Handle<Vec> prolonged(const Coarsening& coarsening, Vec x) const {
    Handle<Vec> y;
    check(MatCreateVecs(coarsening.prolongation.get(), nullptr, y.out()));
    check(MatMult(coarsening.prolongation.get(), x, y.get()));
    return y;
  }

  /// Values at the vertices of functions on all nodes, as coarse functions.
  static std::vector<Handle<Vec>> at_vertices(const Coarsening& coarsening, const std::vector<Handle<Vec>>& fine) {
    Mat P = coarsening.prolongation.get();
    std::vector<Handle<Vec>> coarse(fine.size());
    for (std::size_t m = 0; m < fine.size(); ++m) {
      check(MatCreateVecs(P, coarse[m].out(), nullptr));
      const ConstArrayView from(fine[m].get());
      const ArrayView to(coarse[m].get());
      PetscInt begin = 0, end = 0, first = 0;
      check(MatGetOwnershipRange(P, &begin, &end));
      check(MatGetOwnershipRangeColumn(P, &first, nullptr));
      for (PetscInt row = begin; row < end; ++row) {
        PetscInt count = 0;
        const PetscInt* columns = nullptr;
        const PetscScalar* values = nullptr;
        check(MatGetRow(P, row, &count, &columns, &values));
        if (count == 1 && values[0] == 1.0) to[columns[0] - first] = from[row - begin];
        check(MatRestoreRow(P, row, &count, &columns, &values));
      }
    }
    return coarse;
  }

  Scratch scratch_{comm};
  std::string file_;
  Body body_;
};

// Rigid motions are linear functions: their prolongations are rigid motions.
TEST_F(Coarsenings, LinearFunctionsAreProlongedExactly) {
  const std::vector<char> nothing(3 * static_cast<std::size_t>(layout().num_local_nodes), 0);
  const auto coarsening = make_coarsening(layout(), nothing);
  const auto fine = near_null_space(comm, rigid_body_modes(layout(), nothing));
  const auto coarse = at_vertices(coarsening, rigid_body_modes(layout(), nothing));
  for (std::size_t m = 0; m < coarse.size(); ++m) {
    const auto rest = prolonged(coarsening, coarse[m].get());
    PetscReal before = 0.0, after = 0.0;
    check(VecNorm(rest.get(), NORM_2, &before));
    check(MatNullSpaceRemove(fine.get(), rest.get()));
    check(VecNorm(rest.get(), NORM_2, &after));
    EXPECT_GT(before, 0.5) << "mode " << m;
    EXPECT_LE(after, 1e-13 * before) << "mode " << m;
  }
}

// A prescribed entry at a vertex stands alone, one between vertices stays at zero.
TEST_F(Coarsenings, PrescribedEntriesAreOutOfReach) {
  std::vector<char> prescribed(3 * static_cast<std::size_t>(layout().num_local_nodes), 0);
  for (PetscInt n = 0; n < layout().num_local_nodes; ++n) {
    const auto X = layout().position(n);
    for (int i = 0; i < 3; ++i) prescribed[static_cast<std::size_t>(3 * n + i)] = X[0] < 0.5 && i != 1;
  }
  const auto coarsening = make_coarsening(layout(), prescribed);
  Mat P = coarsening.prolongation.get();
  PetscInt begin = 0, end = 0, held = 0;
  check(MatGetOwnershipRange(P, &begin, &end));
  ASSERT_EQ(end - begin, 3 * layout().num_owned_nodes);
  for (PetscInt row = begin; row < end; ++row) {
    PetscInt count = 0;
    const PetscScalar* values = nullptr;
    check(MatGetRow(P, row, &count, nullptr, &values));
    if (prescribed[static_cast<std::size_t>(row - begin)]) {
      ++held;
      EXPECT_LE(count, 1);
      if (count == 1) {
        EXPECT_EQ(values[0], 1.0);
      }
    }
    check(MatRestoreRow(P, row, &count, nullptr, &values));
  }
  PetscInt total = 0;
  check_mpi(MPI_Allreduce(&held, &total, 1, MPIU_INT, MPI_SUM, comm));
  EXPECT_GT(total, 0);
  // Columns of prescribed vertices have that one entry, so that the coarse matrix keeps them apart as the fine one
  // does.
  for (const Handle<Vec>& mode : at_vertices(coarsening, rigid_body_modes(layout(), prescribed))) {
    const auto P_mode = prolonged(coarsening, mode.get());
    const ConstArrayView values(P_mode.get());
    for (PetscInt i = 0; i < 3 * layout().num_owned_nodes; ++i) {
      if (prescribed[static_cast<std::size_t>(i)]) {
        EXPECT_EQ(values[i], 0.0);
      }
    }
  }
}

}  // namespace
}  // namespace pliant::test_coarsening
