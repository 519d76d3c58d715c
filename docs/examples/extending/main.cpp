/// trapped INPUT.yaml: `pliant run` with one law and one term more. Runs under mpirun as pliant does.
#include "command/exit_status.hpp"
#include "demiray.hpp"
#include "input/input.hpp"
#include "material/law_kind.hpp"
#include "petsc/session.hpp"
#include "run/run.hpp"
#include "trap.hpp"

#include <cstdio>
#include <memory>

namespace {

constexpr double stiffness = 9000.0;  // [N/m^4]
constexpr std::array centre{2.0, 0.5, 0.5};

std::vector<std::unique_ptr<pliant::EnergyTerm>> additional_terms(const pliant::Model& model) {
  if (model.layout().order != 1) throw pliant::InputError({}, "the trap is written for `element: P1`");
  std::vector<std::unique_ptr<pliant::EnergyTerm>> terms;
  terms.push_back(std::make_unique<Trap>(model.layout(), model.pattern(), stiffness, centre));
  return terms;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: trapped INPUT.yaml\n");
    return static_cast<int>(pliant::ExitCode::input);
  }
  pliant::add_elastic_law(demiray_info, pliant::law_kind<Demiray>());
  const pliant::Session session(argv[0], {});
  return pliant::exit_status([&] {
    const pliant::Config config = pliant::read_input_file(PETSC_COMM_WORLD, argv[1], {});
    pliant::Console console(PETSC_COMM_WORLD, pliant::Verbosity::normal);
    return pliant::run_with_output(PETSC_COMM_WORLD, config, console, additional_terms);
  });
}
