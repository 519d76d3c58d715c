#include "input/checks/time.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"

#include <optional>
#include <string>

namespace pliant {
namespace {

constexpr double most_steps = 1e9;  // steps are counted in an int

std::string seconds(double time) {
  return format_number(time) + " s";
}

/// Why the steps of this analysis cannot follow from their error; nothing if they can.
std::optional<std::string> why_not_adaptive(const TimeConfig& time) {
  if (const Method* method = method_of(time)) return why_not_adaptive(*method);
  const bool is_petsc = std::holds_alternative<MethodConfig::PetscIntegrator>(time.method.kind);
  return "method '" + method_name(time.method) + "' " +
         (is_petsc ? "takes fixed steps" : "has no motion whose error could be estimated");
}

/// Is the end given, and could it be read?
bool end_is_known(const TimeConfig& time, const InputNode& section) {
  const InputNode* end = given(section, {"end"});
  if (end == nullptr || time.end > 0) return end != nullptr;
  const std::string number = end->text.substr(0, end->text.find(' '));  // a unit may follow
  return parse_number(number) == 0.0;
}

void check_step(const TimeConfig& time, const InputNode& section, Diagnostics& diagnostics) {
  const InputNode* step = given(section, {"step"});
  if (time.step <= 0 || !end_is_known(time, section)) return;
  const Location& where = step != nullptr ? step->where : time.method.where;
  if (time.step > time.end) {
    diagnostics.add(where, "the step of " + seconds(time.step) + " is longer than the simulation, which ends at " +
                               seconds(time.end));
  } else if (time.end / time.step > most_steps) {
    diagnostics.add(where, "the step of " + seconds(time.step) + " would need " + format_number(time.end / time.step) +
                               " steps to the end; at most " + format_number(most_steps) + " are possible");
  }
  const InputNode* min_step = given(section, {"min_step"});
  if (min_step != nullptr && time.adaptive) {
    diagnostics.add(min_step->key_where, "'min_step' belongs in 'adaptive' where steps adapt");
  } else if (min_step != nullptr && time.min_step > time.step) {
    diagnostics.add(min_step->where, "'min_step' is larger than the step of " + seconds(time.step));
  }
}

void check_adaptive(const TimeConfig& time, const InputNode& section, Diagnostics& diagnostics) {
  if (!time.adaptive) return;
  const AdaptiveConfig& adaptive = *time.adaptive;
  if (const auto reason = why_not_adaptive(time)) {
    diagnostics.add(adaptive.where, "steps cannot adapt: " + *reason + "; choose another method or remove 'adaptive'");
  }
  if (time.step <= 0) {
    if (!why_not_adaptive(time) && given(section, {"step"}) == nullptr && end_is_known(time, section)) {
      diagnostics.add(given(section, {"end"})->where,
                      "'end' must be > 0 [s] where steps adapt, because the first step follows from it");
    }
    return;
  }
  const InputNode* min_step = given(section, {"adaptive", "min_step"});
  const InputNode* max_step = given(section, {"adaptive", "max_step"});
  if (min_step != nullptr && max_step != nullptr && adaptive.min_step > adaptive.max_step) {
    diagnostics.add(min_step->where, "'min_step' is larger than 'max_step', " + seconds(adaptive.max_step));
  } else if (min_step != nullptr && adaptive.min_step > time.step) {
    diagnostics.add(min_step->where, "'min_step' is larger than the first step, " + seconds(time.step));
  } else if (max_step != nullptr && adaptive.max_step < time.step) {
    diagnostics.add(max_step->where, "'max_step' is smaller than the first step, " + seconds(time.step));
  }
}

void check_events(const TimeConfig& time, const InputNode& section, Diagnostics& diagnostics) {
  const InputNode* events = given(section, {"events"});
  if (events == nullptr) return;
  double last = 0.0;
  for (std::size_t i = 0; i < time.events.size(); ++i) {
    const double event = time.events[i];
    if (event <= 0.0) continue;  // could not be read
    const Location& where = events->children[i].where;
    if (end_is_known(time, section) && event >= time.end) {
      diagnostics.add(where, "the event at " + seconds(event) + " is not before the end, " + seconds(time.end));
    } else if (event <= last) {
      diagnostics.add(where, "events must be in ascending order, but " + seconds(event) + " follows " + seconds(last));
    }
    last = event;
  }
}

}  // namespace

void check_time(const TimeConfig& time, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* section = given(root, {"time"});
  if (section == nullptr || section->kind != InputNode::Kind::map ||
      std::holds_alternative<MethodConfig::Unknown>(time.method.kind))
    return;
  check_adaptive(time, *section, diagnostics);
  if (analysis_of(time) == Analysis::static_equilibrium) return;
  if (given(*section, {"step"}) == nullptr && !time.adaptive) {
    diagnostics.add({section->where, {"step", "adaptive"}}, section->where, "missing key 'step' in time");
  }
  if (given(*section, {"end"}) == nullptr) {
    diagnostics.add({section->where, {"end"}}, section->where, "missing key 'end' in time");
  }
  check_step(time, *section, diagnostics);
  check_events(time, *section, diagnostics);
}

void check_path(const Config& config, Diagnostics& diagnostics) {
  if (!config.time.path || std::holds_alternative<MethodConfig::Unknown>(config.time.method.kind)) return;
  const PathConfig& path = *config.time.path;
  if (analysis_of(config.time) != Analysis::static_equilibrium) {
    diagnostics.add(path.where, "'path' follows equilibria and needs 'method: static'; with '" +
                                    method_name(config.time.method) + "' loads follow time");
  }
  if (config.contact) {
    diagnostics.add(config.contact->where,
                    "a path of equilibria cannot include contact, which makes it bend abruptly; remove 'contact', or "
                    "'path'. A motion through contact and snapping needs a method in time, such as 'bdf2'");
  }
  if (config.solver.linear == LinearSolver::amg || config.solver.linear == LinearSolver::p_multigrid) {
    diagnostics.add(path.where,
                    "a path leads through states whose stiffness is not positive definite, which multigrid cannot "
                    "solve; remove 'solver.linear', or choose 'cholesky'");
  }
  const double first = 1.0 / config.time.load_steps;
  if (path.max_step && *path.max_step < first) {
    diagnostics.add(path.where, "'max_step' of " + format_number(*path.max_step) +
                                    " is smaller than the first step, 1 / load_steps = " + format_number(first) +
                                    "; give more 'load_steps'");
  }
}

}  // namespace pliant
