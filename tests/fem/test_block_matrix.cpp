// Writing cell blocks straight into the matrix against PETSc's own insertion.
#include "fem/body.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

namespace pliant::test_block_matrix {
namespace {

using test::Body;
using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;

const MPI_Comm comm = MPI_COMM_WORLD;

/// The (i, j) entry of the block of nodes at X and Y of a cell around M; symmetric under (X, i) <-> (Y, j).
double entry(const Point& M, const Point& X, int i, const Point& Y, int j) {
  return test::rough(M, 0, 1) + test::rough(X, i, 2) * test::rough(Y, j, 2);
}

class Matrices : public test::OnBodies {
 protected:
  Point middle(PetscInt cell) const {
    Point m{};
    for (const PetscInt n : layout_.nodes_of_cell(cell).first(4)) {
      const Point x = layout_.position(n);
      for (int k = 0; k < 3; ++k) m[k] += 0.25 * x[k];
    }
    return m;
  }

  /// Calls `visit(row node, column node, i, j, value)` for the entries of the cells.
  template <class Visit>
  void for_each_entry(PetscInt num_cells, Visit visit) const {
    for (PetscInt c = 0; c < num_cells; ++c) {
      const Point m = middle(c);
      for (const PetscInt a : layout_.nodes_of_cell(c)) {
        for (const PetscInt b : layout_.nodes_of_cell(c)) {
          for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) visit(a, b, i, j, entry(m, layout_.position(a), i, layout_.position(b), j));
          }
        }
      }
    }
  }

  /// From all local cells into rows of owned nodes.
  Handle<Mat> written() const {
    Handle<Mat> K = make_matrix(layout_, body_.pattern);
    BlockWriter writer(body_.pattern, K.get());
    writer.zero();
    for_each_entry(layout_.num_local_cells, [&](PetscInt a, PetscInt b, int i, int j, double value) {
      if (a >= layout_.num_owned_nodes) return;
      const auto [values, stride] = writer.block(a, body_.pattern.block(a, b));
      values[i * stride + j] += value;
    });
    writer.finish();
    return K;
  }

  /// From owned cells, communicated by PETSc.
  Handle<Mat> inserted() const {
    Handle<Mat> K;
    const PetscInt size = 3 * layout_.num_owned_nodes;
    check(MatCreate(comm, K.out()));
    check(MatSetSizes(K.get(), size, size, PETSC_DETERMINE, PETSC_DETERMINE));
    check(MatSetType(K.get(), MATMPIAIJ));
    check(MatSetUp(K.get()));
    check(MatSetOption(K.get(), MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
    for_each_entry(layout_.num_owned_cells, [&](PetscInt a, PetscInt b, int i, int j, double value) {
      const PetscInt row = 3 * layout_.global_node(a) + i, column = 3 * layout_.global_node(b) + j;
      check(MatSetValue(K.get(), row, column, value, ADD_VALUES));
    });
    check(MatAssemblyBegin(K.get(), MAT_FINAL_ASSEMBLY));
    check(MatAssemblyEnd(K.get(), MAT_FINAL_ASSEMBLY));
    return K;
  }

  static double size_of(Mat A) {
    PetscReal norm = 0.0;
    check(MatNorm(A, NORM_FROBENIUS, &norm));
    return norm;
  }

  static double difference(Mat A, Mat B) {
    Handle<Mat> D;
    check(MatDuplicate(A, MAT_COPY_VALUES, D.out()));
    check(MatAXPY(D.get(), -1.0, B, DIFFERENT_NONZERO_PATTERN));
    return size_of(D.get());
  }

  /// One entry in three or so, ghosts as their owners.
  std::vector<char> some_prescribed() const {
    std::vector<char> flags;
    for (PetscInt a = 0; a < layout_.num_local_nodes; ++a) {
      for (int i = 0; i < 3; ++i) flags.push_back(test::rough(layout_.position(a), i, 5) > 0.5);
    }
    return flags;
  }
};

INSTANTIATE_TEST_SUITE_P(Bodies, Matrices,
                         ::testing::Values(BodySpec{1, Shape::jittered, 1}, BodySpec{1, Shape::jittered, 3},
                                           BodySpec{2, Shape::jittered, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

TEST_P(Matrices, WrittenBlocksAreWherePetscPutsThem) {
  const auto K = written(), expected = inserted();
  ASSERT_GT(size_of(expected.get()), 1.0);
  EXPECT_LE(difference(K.get(), expected.get()), 1e-14 * size_of(expected.get()));
  MatInfo info, expected_info;
  check(MatGetInfo(K.get(), MAT_GLOBAL_SUM, &info));
  check(MatGetInfo(expected.get(), MAT_GLOBAL_SUM, &expected_info));
  EXPECT_EQ(info.nz_used, expected_info.nz_used);  // no place that no cell fills
}

TEST_P(Matrices, ProductsSeeTheNewValuesAfterASecondWriting) {
  const auto K = written(), expected = inserted();
  const Handle<Vec> x = make_vector(layout_), y = make_vector(layout_), z = make_vector(layout_);
  {
    const ArrayView at(x.get());
    for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
      at[i] = test::rough(layout_.position(i / 3), static_cast<int>(i % 3), 7);
    }
  }
  check(MatMult(K.get(), x.get(), y.get()));
  {
    BlockWriter writer(body_.pattern, K.get());
    writer.zero();
    writer.finish();
  }
  check(MatMult(K.get(), x.get(), z.get()));
  PetscReal size = 0.0;
  check(VecNorm(z.get(), NORM_2, &size));
  EXPECT_EQ(size, 0.0);
  check(MatMult(expected.get(), x.get(), z.get()));
  check(VecNorm(z.get(), NORM_2, &size));
  check(VecAXPY(y.get(), -1.0, z.get()));
  PetscReal error = 0.0;
  check(VecNorm(y.get(), NORM_2, &error));
  EXPECT_LE(error, 1e-14 * size);
}

TEST_P(Matrices, DiagonalIsThatOfTheMatrix) {
  const auto K = written();
  const Handle<Vec> expected = make_vector(layout_);
  check(MatGetDiagonal(K.get(), expected.get()));
  std::vector<double> diagonal(3 * static_cast<std::size_t>(layout_.num_owned_nodes), NAN);
  BlockWriter(body_.pattern, K.get()).copy_diagonal(diagonal);
  const ConstArrayView at(expected.get());
  for (std::size_t i = 0; i < diagonal.size(); ++i) EXPECT_EQ(diagonal[i], at[static_cast<PetscInt>(i)]);
}

TEST_P(Matrices, EliminationIsPetscsAndSymmetric) {
  const auto K = written(), expected = inserted();
  const auto flags = some_prescribed();
  const double diagonal = 2.5;
  {
    BlockWriter writer(body_.pattern, K.get());
    RowElimination(layout_, body_.pattern, flags).apply(writer, diagonal);
    writer.finish();
  }
  std::vector<PetscInt> rows;
  for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
    if (flags[static_cast<std::size_t>(i)]) rows.push_back(3 * layout_.first_global_node + i);
  }
  EXPECT_GT(sum(comm, PetscInt64{static_cast<PetscInt>(rows.size())}), 0);
  check(
      MatZeroRowsColumns(expected.get(), static_cast<PetscInt>(rows.size()), rows.data(), diagonal, nullptr, nullptr));
  EXPECT_LE(difference(K.get(), expected.get()), 1e-14 * size_of(expected.get()));
  Handle<Mat> T;
  check(MatTranspose(K.get(), MAT_INITIAL_MATRIX, T.out()));
  EXPECT_LE(difference(K.get(), T.get()), 1e-14 * size_of(K.get()));
}

TEST_P(Matrices, RigidBodyModesAreOrthonormalMotionsOfTheFreeEntries) {
  const auto K = written();
  for (const bool free : {true, false}) {
    const auto flags =
        free ? std::vector<char>(3 * static_cast<std::size_t>(layout_.num_local_nodes), 0) : some_prescribed();
    set_near_null_modes(K.get(), rigid_body_modes(layout_, flags));
    MatNullSpace space = nullptr;
    PetscBool has_constant = PETSC_TRUE;
    PetscInt count = 0;
    const Vec* modes = nullptr;
    check(MatGetNearNullSpace(K.get(), &space));
    ASSERT_NE(space, nullptr);
    check(MatNullSpaceGetVecs(space, &has_constant, &count, &modes));
    EXPECT_EQ(count, 6);
    EXPECT_FALSE(has_constant);
    for (PetscInt m = 0; m < count; ++m) {
      for (PetscInt n = 0; n <= m; ++n) {
        PetscScalar product = 0.0;
        check(VecDot(modes[m], modes[n], &product));
        EXPECT_NEAR(product, m == n ? 1.0 : 0.0, 1e-12);
      }
      const ConstArrayView mode(modes[m]);
      for (PetscInt i = 0; i < 3 * layout_.num_owned_nodes; ++i) {
        if (flags[static_cast<std::size_t>(i)]) {
          EXPECT_EQ(mode[i], 0.0);
        }
      }
    }
  }
}

// With everything prescribed nothing is left of the modes.
TEST_P(Matrices, NoModeIsLeftOfAFullyPrescribedBody) {
  const auto K = written();
  set_near_null_modes(
      K.get(), rigid_body_modes(layout_, std::vector<char>(3 * static_cast<std::size_t>(layout_.num_local_nodes), 1)));
  MatNullSpace space = nullptr;
  PetscInt count = -1;
  check(MatGetNearNullSpace(K.get(), &space));
  if (space != nullptr) {
    check(MatNullSpaceGetVecs(space, nullptr, &count, nullptr));
    EXPECT_EQ(count, 0);
  }
}

}  // namespace
}  // namespace pliant::test_block_matrix
