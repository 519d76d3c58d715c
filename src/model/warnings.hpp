/// Warnings about inputs that are legal but probably not what was meant, and notes.
#pragma once

#include "energy/constraint/prescribed.hpp"
#include "input/config.hpp"
#include "model/selections.hpp"

#include <optional>
#include <vector>

namespace pliant {

/// Those of `warnings_about` that ask whether densities and moduli of bodies are in SI units.
std::vector<Diagnostic> warnings_about_units(const Config& config);

/// Warnings that need only the input, including those about its text.
std::vector<Diagnostic> warnings_about(const Config& config);

/// Warns of a method with several stages, in a dynamic analysis of incompressible bodies: the pressure is the
/// multiplier of a constraint on the displacement (a problem of index 3), whose order is that of a stage, less two.
std::optional<Diagnostic> warning_about_pressures(const Config& config);

/// Warns of bodies whose resistance to a change of volume makes Newton's method slow, as it is with `iterations` per
/// stage; at most one warning.
std::vector<Diagnostic> warnings_about_iterations(const Config& config, double iterations);

/// Does the input leave the bodies at rest? Terms that a program adds may still move them.
bool nothing_moves(const Config& config);

/// Can bodies that no constraint holds fall: do loads push them, while neither contact nor springs stop them, and they
/// have no initial velocity?
bool may_fall(const Config& config);

/// Notes about what the input contains and its kind of analysis does not use.
std::vector<Diagnostic> notes_of_idle_keys(const Config& config);

/// Warns of constraints that displace the initial state abruptly. Collective over the ranks of `layout`, like the next.
std::vector<Diagnostic> warnings_about_start(const Config& config, const NodeLayout& layout, Selections& selections);

/// Warns of constraints that hold every node, and of loads on parts whose displacement is prescribed at every node:
/// they move nothing. `selections` must be free of errors.
std::vector<Diagnostic> warnings_about_what_is_held(const Config& config, const NodeLayout& layout,
                                                    Selections& selections, const PrescribedDisplacement& prescribed);

}  // namespace pliant
