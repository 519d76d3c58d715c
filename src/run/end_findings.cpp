#include "run/end_findings.hpp"

#include "input/analysis.hpp"
#include "petsc/check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace pliant {
namespace {

/// A smaller kinetic energy than this part of the energy supplied is that of bodies at rest.
constexpr double rest = 0.01;
/// A larger part of the energy supplied than this is too much for a method of the first order, too.
constexpr double much = 0.5;
/// A larger part of the energies than this that cannot be accounted for is more than rounding.
constexpr double unbalanced = 0.01;
/// Steps are too long for the rates of materials where the works miss more than this part of what those dissipate.
constexpr double too_long = 0.05;
/// Smaller energies are rounding errors of bodies without loads [J].
constexpr double no_energy = 1e-20;
/// Surfaces that are further in each other than this part of the largest displacement change what is looked at.
constexpr double visible = 0.05;
/// What is less than this part of the size of the mesh does not show.
constexpr double too_small_to_see = 1e-3;

Diagnostic finding_about_loss(const Config& config, const EnergyWatch::Loss& loss, double kinetic,
                              double longest_step) {
  const Method* method = integrator_of(config);
  const bool is_first_order = method != nullptr && method->order == 1;
  const std::string what = fmt::format(
      "'{}' with steps of {:g} s dissipated {:.3g} J, {:.0f} % of the energy supplied ({:.3g} J), besides what the "
      "material dissipates",
      method_name(config.time.method), longest_step, loss.dissipated, 100.0 * loss.share(), loss.supplied);
  if (config.contact) {
    return {Severity::note, config.time.method.where,
            what +
                ": impacts shorter than a step, and the vibrations after them, lose their energy to the method; "
                "where the motion after an impact matters, use shorter steps and a viscosity"};
  }
  const std::string remedy = is_first_order ? "use shorter steps, or bdf2 or dirk33" : "use shorter steps";
  const bool is_at_rest = kinetic < rest * loss.supplied;
  if (is_first_order && (is_at_rest || loss.share() < much)) {
    return {Severity::note, config.time.method.where,
            fmt::format("{}: {}; where the motion matters, {}", what,
                        is_at_rest ? "the state of rest at the end does not depend on that"
                                   : "methods of the first order damp all vibrations",
                        remedy)};
  }
  return {
      Severity::warning, config.time.method.where,
      fmt::format("{}: the steps are too long for this motion, whose vibrations are damped away; {}", what, remedy)};
}

}  // namespace

std::vector<Diagnostic> findings_about_energy(const Config& config, const EnergyWatch& watch, const Energies& end,
                                              double longest_step) {
  std::vector<Diagnostic> found;
  if (const auto growth = watch.growth()) {
    const std::string name = method_name(config.time.method);
    const bool damps = name == "bdf2" || name == "dirk22" || name == "dirk33";
    found.push_back(
        {Severity::warning, config.time.method.where,
         fmt::format("the energy grew without work: at t = {:.6g} s it was {:.3g} times the energy supplied{}, with "
                     "steps of {:g} s of '{}'; use shorter steps{}, damp the vibrations with a viscosity, or replace "
                     "jumps of prescribed displacements by ramps",
                     growth->time, growth->factor, growth->includes_dissipation ? " (including dissipation)" : "",
                     longest_step, name, damps ? "" : " or bdf2, dirk22 or dirk33")});
  }
  if (const auto loss = watch.loss(end)) found.push_back(finding_about_loss(config, *loss, end.kinetic, longest_step));
  return found;
}

std::vector<Diagnostic> findings_about_equilibria(const Config& config, const Ledger& ledger) {
  std::vector<Diagnostic> found;
  const auto warn = [&](std::string text) {
    found.push_back({Severity::warning, config.time.method.where, std::move(text)});
  };
  const Energies& end = ledger.energies();
  const double size = std::max({std::abs(end.load_work), std::abs(end.elastic), std::abs(end.load_potential)});
  if (size > no_energy && std::abs(end.balance_error) > unbalanced * size) {
    warn(
        fmt::format("the energies do not balance: {:.3g} J of {:.3g} J cannot be accounted for, so that states "
                    "are not solutions; is there a body that nothing holds?",
                    std::abs(end.balance_error), size));
  }
  const double lost = end.numerical_dissipation - ledger.lost_at_start();
  if (end.dissipated > unbalanced * size && std::abs(lost) > too_long * end.dissipated) {
    warn(
        fmt::format("the works between equilibria miss {:.3g} J, {:.0f} % of what material and friction dissipated "
                    "({:.3g} J): rates are those of backward Euler, of the first order, and errors of the dissipation "
                    "are larger than that; unless a body snaps or slips suddenly, use shorter steps",
                    std::abs(lost), 100.0 * std::abs(lost) / end.dissipated, end.dissipated));
  }
  return found;
}

std::vector<Diagnostic> findings_about_solutions(const Config& config, const SolverStatistics& statistics,
                                                 Forces forces) {
  const SolverStatistics& s = statistics;
  std::vector<Diagnostic> found;
  const auto warn = [&](const Location& where, std::string text) {
    found.push_back({Severity::warning, where, std::move(text)});
  };
  if (config.solver.newton.absolute > 0.0 && 2 * s.unbalanced_stops > s.stages) {
    warn({config.file, 0, 0},
         fmt::format("'solver.newton.absolute' of {:g} N ended {} of {} solves while more than a tenth of the forces "
                     "was unbalanced: these are not solutions; give a smaller value, or omit the key",
                     config.solver.newton.absolute, s.unbalanced_stops, s.stages));
  }
  if (s.worst_rounding > doubtful_rounding && forces == Forces::some) {
    warn({}, fmt::format("{} of {} solves ended at the limit of double precision, one of them with {:.1e} of the "
                         "forces unbalanced: {}",
                         s.rounding_stops, s.stages, s.worst_rounding,
                         config.contact ? "contact or friction, or bodies that are stiff relative to the forces on "
                                          "them, allow no more accurate solution; compare with a run of shorter steps "
                                          "where these forces matter"
                                        : "the bodies are too stiff relative to the forces on them for a more accurate "
                                          "solution"));
  }
  if (s.unsettled_stages > 0) {
    found.push_back({Severity::note,
                     {},
                     fmt::format("in {} of {} solves normal forces jump between two states, as where points of contact "
                                 "lie over edges of the other mesh; friction lacks at most {:.1e} of its forces there",
                                 s.unsettled_stages, s.stages, s.worst_unsettled)});
  }
  if (s.unstable_stages > 0) {
    warn({}, fmt::format("{} of {} solves found an unstable equilibrium: at the slightest disturbance the body buckles "
                         "or snaps; a dynamic analysis (`time: {{method: bdf2, ...}}`) shows the motion that follows",
                         s.unstable_stages, s.stages));
  }
  return found;
}

std::vector<Diagnostic> findings_about_contact(const Config& config, const Model& model, const StepRecord& last) {
  if (!config.contact) return {};
  double displacement = 0.0;
  check(VecNorm(last.q, NORM_INFINITY, &displacement));
  const auto& box = model.mesh_report().bounds;
  const double size = std::hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]), depth = -last.contact.gap;
  if (!(displacement > 0.0 && depth > std::max(visible * displacement, too_small_to_see * size))) return {};
  return {
      {Severity::note, config.contact->where,
       fmt::format("a penalty gives way where bodies touch: at the end they are up to {:.3g} m in each other or in "
                   "an obstacle, {:.0f} % of the largest displacement; where that matters, use 'law: barrier', which "
                   "does not, or a larger 'stiffness'",
                   depth, 100.0 * depth / displacement)}};
}

}  // namespace pliant
