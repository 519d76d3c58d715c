#include "energy/equation/pressure_projection.hpp"

#include "petsc/check.hpp"

#include <vector>

namespace pliant {

Handle<Mat> make_compliance(std::span<const MixedTerm* const> terms, const NodeLayout& layout,
                            const PressureLayout& pressures) {
  const auto global = [&](PetscInt p) {
    return p < pressures.num_owned ? pressures.first_global + p
                                   : pressures.ghost_globals[static_cast<std::size_t>(p - pressures.num_owned)];
  };
  std::vector<PetscInt> rows, columns;
  std::vector<double> values;
  const std::vector<double> rest(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  for (const MixedTerm* term : terms) {
    term->couple(rest, [&](const PressureCoupling& cells) {
      for (int lane = 0; lane < cells.num_lanes; ++lane) {
        for (int b = 0; b < 4; ++b) {
          if (cells.pressures[b][lane] >= pressures.num_owned) continue;
          for (int c = 0; c < 4; ++c) {
            rows.push_back(global(cells.pressures[b][lane]));
            columns.push_back(global(cells.pressures[c][lane]));
            values.push_back(cells.C[b][c][lane]);
          }
        }
      }
    });
  }
  Handle<Mat> C;
  check(MatCreate(layout.comm, C.out()));
  check(MatSetSizes(C.get(), pressures.num_owned, pressures.num_owned, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetType(C.get(), MATAIJ));
  check(MatSetPreallocationCOO(C.get(), static_cast<PetscCount>(rows.size()), rows.data(), columns.data()));
  check(MatSetValuesCOO(C.get(), values.data(), INSERT_VALUES));
  return C;
}

PressureProjection::PressureProjection(Handle<Mat> compliance) {
  check(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(compliance.get())), solver_.out()));
  check(KSPSetOperators(solver_.get(), compliance.get(), compliance.get()));
  check(KSPSetType(solver_.get(), KSPCG));
  PC pc = nullptr;
  check(KSPGetPC(solver_.get(), &pc));
  check(PCSetType(pc, PCJACOBI));
  check(KSPSetTolerances(solver_.get(), 1e-13, PETSC_DEFAULT, PETSC_DEFAULT, 200));
}

void PressureProjection::solve(Vec r, Vec p) {
  check(KSPSolve(solver_.get(), r, p));
}

}  // namespace pliant
