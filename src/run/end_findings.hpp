/// What a run as a whole shows at its end: warnings and notes about its energy and its solves.
#pragma once

#include "base/error.hpp"
#include "input/config.hpp"
#include "run/energy_watch.hpp"
#include "run/simulation.hpp"
#include "solver/statistics.hpp"

#include <vector>

namespace pliant {

/// Warns of a motion whose method created energy, or dissipated a large part of it. A note says so where that is
/// usual: with contact, whose impacts are shorter than steps, and for methods of the first order, as long as they
/// dissipate less than half or have brought the bodies to rest. `end`: the energies of the last step; `longest_step`
/// [s].
std::vector<Diagnostic> findings_about_energy(const Config& config, const EnergyWatch& watch, const Energies& end,
                                              double longest_step);

/// Without inertia: warns of energies that do not balance, and of steps that are too long for the rates of the
/// materials.
std::vector<Diagnostic> findings_about_equilibria(const Config& config, const Ledger& ledger);

/// What moves the bodies of a run.
enum class Forces { some, none_but_rounding };

/// Warns of solves that have not found a solution, inaccurate ones, and equilibria that are unstable. Where all forces
/// are rounding errors, solves need not balance them.
std::vector<Diagnostic> findings_about_solutions(const Config& config, const SolverStatistics& statistics,
                                                 Forces forces);

/// A note where a penalty gives way so far in the last state that it shows. Collective.
std::vector<Diagnostic> findings_about_contact(const Config& config, const Model& model, const StepRecord& last);

}  // namespace pliant
