#include "energy/equation/pressure_projection.hpp"

#include "petsc/check.hpp"
#include "petsc/collective.hpp"

#include <vector>

namespace pliant {

Handle<Mat> make_compliance(std::span<const MixedTerm* const> terms, const NodeLayout& layout,
                            const PressureLayout& pressures, const Instant& at) {
  const auto global = [&](PetscInt p) {
    return p < pressures.num_owned ? pressures.first_global + p
                                   : pressures.ghost_globals[static_cast<std::size_t>(p - pressures.num_owned)];
  };
  std::vector<PetscInt> rows, columns;
  std::vector<double> values;
  const std::vector<double> rest(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  for (const MixedTerm* term : terms) {
    term->couple(at, rest, [&](const PressureCoupling& cells) {
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

bool are_felt(std::span<const MixedTerm* const> terms, const NodeLayout& layout, std::span<const char> prescribed,
              std::span<const char> is_idle) {
  constexpr double rounding = 1e-10;
  const std::vector<double> rest(3 * static_cast<std::size_t>(layout.num_local_nodes), 0.0);
  std::vector<double> of_all(rest.size(), 0.0);
  // The force of a pressure of 1 Pa in incompressible cells: zero but where it is felt.
  const auto is_felt = [&](const std::vector<double>& force) {
    double size = 0.0, free = 0.0;
    for (PetscInt i = 0; i < 3 * layout.num_owned_nodes; ++i) {
      const double square = force[static_cast<std::size_t>(i)] * force[static_cast<std::size_t>(i)];
      size += square;
      if (!prescribed[static_cast<std::size_t>(i)]) free += square;
    }
    size = sum(layout.comm, size);
    return size == 0.0 || sum(layout.comm, free) > rounding * rounding * size;
  };
  bool result = true;
  for (const MixedTerm* term : terms) {
    std::vector<double> force(rest.size(), 0.0);
    bool is_compressible = false;
    term->couple({}, rest, [&](const PressureCoupling& cells) {
      for (int lane = 0; lane < cells.num_lanes; ++lane) {
        is_compressible = is_compressible || cells.is_compressible[lane];
        for (std::size_t row = 0; row < cells.B.size(); ++row) {
          double& entry = force[static_cast<std::size_t>(3 * cells.nodes[row / 3][lane]) + row % 3];
          for (std::size_t b = 0; b < 4; ++b) {
            if (!is_idle[static_cast<std::size_t>(cells.pressures[b][lane])]) entry += cells.B[row][b][lane];
          }
        }
      }
    });
    if (maximum(layout.comm, is_compressible ? 1.0 : 0.0) > 0.0) continue;
    result = is_felt(force) && result;
    for (std::size_t i = 0; i < force.size(); ++i) of_all[i] += force[i];
  }
  return is_felt(of_all) && result;
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
