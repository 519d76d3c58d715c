#include "input/checks.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "input/keys.hpp"
#include "input/loads.hpp"
#include "input/volumetric.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <optional>

namespace pliant {
namespace {

constexpr double min_step_divisor = 1024;              // ten halvings
constexpr double min_adaptive_step_divisor = 1 << 20;  // what is fast at the start may last a millionth of the step
constexpr double first_step_divisor = 1000;            // parts of an adaptive run
constexpr double max_step_divisor = 10;
constexpr double most_steps = 1e9;  // steps are counted in an int

/// The node at a path of keys, if it is there and not empty.
const InputNode* given(const InputNode& root, std::initializer_list<std::string_view> path) {
  const InputNode* node = &root;
  for (const std::string_view key : path) {
    node = node->find(key);
    if (node == nullptr || node->kind == InputNode::Kind::null) return nullptr;
  }
  return node;
}

/// The entry of a list of the input.
const InputNode& entry(const InputNode& root, std::string_view list, std::size_t index) {
  return given(root, {list})->children[index];
}

std::string numbered(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

std::string seconds(double time) {
  return format_number(time) + " s";
}

bool is_known(const MethodConfig& method) {
  return !std::holds_alternative<MethodConfig::Unknown>(method.kind);
}

/// Why the steps of this analysis cannot follow from their error; nothing if they can.
std::optional<std::string> why_not_adaptive(const TimeConfig& time) {
  if (const Method* method = method_of(time)) return why_not_adaptive(*method);
  const bool is_petsc = std::holds_alternative<MethodConfig::PetscIntegrator>(time.method.kind);
  return "method '" + method_name(time.method) + "' " +
         (is_petsc ? "runs at the step it is given" : "has no motion whose error could be told");
}

/// Is the end there, and was it understood?
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
    diagnostics.add(min_step->key_where, "'min_step' goes into 'adaptive' where steps adapt");
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
                      "'end' must be > 0 [s] where steps adapt, or there is no first step");
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
      diagnostics.add(where,
                      "events are given in ascending order, but " + seconds(event) + " follows " + seconds(last));
    }
    last = event;
  }
}

void check_time(const TimeConfig& time, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* section = given(root, {"time"});
  if (section == nullptr || section->kind != InputNode::Kind::map || !is_known(time.method)) return;
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

bool may_overlap(const Selection& a, const Selection& b) {
  return a.kind == Selection::Kind::everything || b.kind == Selection::Kind::everything || a.name == b.name;
}

bool damps_by_mass(const ViscosityConfig& mechanism) {
  return std::holds_alternative<MassProportional>(mechanism.law);
}

void check_bodies(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const auto& bodies = config.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!may_overlap(bodies[i].part, bodies[j].part)) continue;
      diagnostics.add(bodies[i].part.where, numbered("bodies", i) + " and " + numbered("bodies", j) +
                                                " fill the same volume; give each a 'volume' of its own");
      break;
    }
    const auto& active = bodies[i].active;
    if (active && active->fibre.empty() && bodies[i].elasticity.directions.empty()) {
      diagnostics.add({active->where, {"fibre"}}, active->where,
                      "missing key 'fibre' in active: the elastic law has no fibres of its own");
    }
    if (given(entry(root, "bodies", i), {"density"}) != nullptr) continue;
    const Analysis analysis = analysis_of(config);
    const auto is_needed_by = [&](const std::string& what) {
      diagnostics.add({bodies[i].where, {"density"}}, bodies[i].where,
                      "missing key 'density' in " + numbered("bodies", i) + ", which " + what + " needs");
    };
    const auto pulls = [&](const LoadConfig& l) {
      return std::holds_alternative<LoadConfig::Gravity>(l.kind) && may_overlap(l.part, bodies[i].part);
    };
    if (is_known(config.time.method) && analysis == Analysis::dynamic) {
      is_needed_by("dynamics");
    } else if (std::any_of(config.loads.begin(), config.loads.end(), pulls)) {
      is_needed_by("gravity");
    } else if (analysis == Analysis::quasistatic && std::ranges::any_of(bodies[i].viscosity, damps_by_mass)) {
      is_needed_by("mass-proportional damping");
    }
  }
}

/// Without inertia, every direction needs a constraint against moving as a whole.
void check_held(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  if (analysis_of(config) == Analysis::dynamic) return;
  const std::string method = method_name(config.time.method);
  // Springs hold, too; in which directions they do shows only against the mesh.
  const auto is_spring = [](const LoadConfig& load) {
    const auto foundation = foundation_of(load);
    return foundation && foundation->spring > 0.0;
  };
  if (std::ranges::any_of(config.loads, is_spring)) return;
  const InputNode* constraints = given(root, {"constraints"});
  const Location& where = config.time.method.where;
  if (constraints == nullptr || constraints->children.empty()) {
    diagnostics.add({root.where, {"constraints"}}, where,
                    "a " + method + " analysis needs constraints; without them the bodies can move as a whole");
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_free = [&](const InputNode& constraint) {
      const InputNode* displacement = given(constraint, {"displacement"});
      return displacement != nullptr && displacement->children.size() == 3 &&
             displacement->children[axis].text == "free";
    };
    if (std::all_of(constraints->children.begin(), constraints->children.end(), is_free)) {
      diagnostics.add(where, "a " + method + " analysis needs a constraint in every direction; none holds " +
                                 std::string(1, "xyz"[axis]));
    }
  }
}

/// Entries of a list that must differ.
void check_unique(const std::vector<std::string>& values, const std::vector<Location>& places, const std::string& what,
                  Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(i);
    if (values[i].empty() || std::find(values.begin(), end, values[i]) == end) continue;
    diagnostics.add(places[i], "the " + what + " '" + values[i] + "' is given twice");
  }
}

void check_names(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  std::vector<Location> places;
  for (std::size_t i = 0; i < config.probes.size(); ++i) {
    const InputNode* name = given(entry(root, "probes", i), {"name"});
    names.push_back(config.probes[i].name);
    places.push_back(name != nullptr ? name->where : config.probes[i].where);
  }
  check_unique(names, places, "probe name", diagnostics);
  names.clear();
  places.clear();
  for (std::size_t i = 0; i < config.cavities.size(); ++i) {
    const InputNode* name = given(entry(root, "cavities", i), {"name"});
    names.push_back(config.cavities[i].name);
    places.push_back(name != nullptr ? name->where : config.cavities[i].where);
  }
  check_unique(names, places, "cavity name", diagnostics);

  const InputNode* fields = given(root, {"output", "fields"});
  if (fields == nullptr || fields->kind != InputNode::Kind::list) return;
  places.clear();
  for (const InputNode& f : fields->children) places.push_back(f.where);
  check_unique(config.output.fields, places, "field", diagnostics);
}

void check_contact(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* contact = given(root, {"contact"});
  if (!config.contact) {
    const InputNode* fields = given(root, {"output", "fields"});
    if (fields == nullptr || contact != nullptr) return;
    for (const InputNode& field : fields->children) {
      if (!field.text.starts_with("contact_")) continue;
      diagnostics.add(field.where, "the field '" + field.text + "' needs 'contact', which this input does not have");
    }
    return;
  }
  const InputNode* obstacles = given(*contact, {"obstacles"});
  if (obstacles == nullptr || obstacles->kind != InputNode::Kind::list) return;
  std::vector<std::string> names;
  std::vector<Location> places;
  for (std::size_t k = 0; k < config.contact->obstacles.size(); ++k) {
    const ObstacleConfig& o = config.contact->obstacles[k];
    const InputNode* name = given(obstacles->children[k], {"name"});
    names.push_back(o.name);
    places.push_back(name != nullptr ? name->where : o.where);
    if (std::holds_alternative<ObstacleConfig::Capsule>(o.shape) &&
        given(obstacles->children[k], {"length"}) == nullptr) {
      diagnostics.add(o.where, "missing key 'length' in " + numbered("obstacles", k) + ", which a capsule needs");
    }
    const auto has_name = [&](const ConstraintConfig& c) { return !o.name.empty() && c.part.name == o.name; };
    if (std::ranges::any_of(config.constraints, has_name)) {
      diagnostics.add(places.back(), "the obstacle name '" + o.name +
                                         "' is that of a constrained part, too, and history.csv has columns of both; "
                                         "choose another one");
    }
  }
  check_unique(names, places, "obstacle name", diagnostics);

  const InputNode* law = given(*contact, {"law"});
  if (config.contact->pressure.law != NormalKind::barrier || law == nullptr) return;
  if (!is_known(config.time.method) || analysis_of(config) != Analysis::dynamic) return;
  if (const Method* own = method_of(config.time); own != nullptr && own->stiffly_accurate) return;
  diagnostics.add(law->where,
                  "a barrier needs a method whose step ends with its last stage (stiffly accurate), or a body "
                  "might end beyond it; '" +
                      method_name(config.time.method) +
                      "' does not: choose backward-euler, bdf2, bdf3, dirk22 or dirk33, or 'law: penalty'");
}

void check_tolerances(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* relative = given(root, {"solver", "newton", "relative"});
  if (relative == nullptr || parse_number(relative->text) != 0.0 || config.solver.newton.absolute > 0) return;
  diagnostics.add(relative->where, "one of 'relative' and 'absolute' in newton must be above 0");
}

void check_linear_solver(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* linear = given(root, {"solver", "linear"});
  if (linear == nullptr || config.solver.linear != LinearSolver::p_multigrid || config.element != ElementOrder::p1)
    return;
  diagnostics.add(
      linear->where,
      "p-multigrid goes from quadratic elements to linear ones, and needs quadratic elements; add 'element: P2', "
      "or use 'amg'");
}

/// The first step is the user's, or else one between the bounds that the user gives.
void complete_adaptive(TimeConfig& time, const InputNode& section) {
  AdaptiveConfig& adaptive = *time.adaptive;
  if (given(section, {"step"}) == nullptr) {
    time.step = std::max(time.end / first_step_divisor, adaptive.min_step);
    if (adaptive.max_step > 0) time.step = std::min(time.step, adaptive.max_step);
  }
  if (adaptive.max_step <= 0) adaptive.max_step = std::max(time.end / max_step_divisor, time.step);
  if (adaptive.min_step <= 0) adaptive.min_step = time.step / min_adaptive_step_divisor;
  if (adaptive.absolute_velocity <= 0 && time.step > 0) adaptive.absolute_velocity = adaptive.absolute / time.step;
  if (given(section, {"min_step"}) == nullptr) time.min_step = adaptive.min_step;
}

void complete_time(TimeConfig& time, const InputNode& root) {
  if (const InputNode* section = given(root, {"time"}); time.adaptive && section != nullptr) {
    complete_adaptive(time, *section);
  }
  if (time.min_step <= 0) time.min_step = time.step / min_step_divisor;
  if (time.startup) return;
  const Method* method = method_of(time);
  time.startup = time.adaptive && method != nullptr && method->num_steps > 1 ? Startup::dirk33 : Startup::ramp;
}

template <class Entries>
void place_whole_mesh_parts(Entries& entries) {
  for (auto& e : entries) {
    if (e.part.kind == Selection::Kind::everything) e.part.where = e.where;
  }
}

}  // namespace

void complete_defaults(Config& config, const InputNode& root) {
  namespace fs = std::filesystem;
  const fs::path input(config.file);
  const fs::path mesh(config.mesh.file.value);
  if (!mesh.empty() && mesh.is_relative()) config.mesh.file.value = (input.parent_path() / mesh).string();
  if (config.contact) {
    for (ObstacleConfig& o : config.contact->obstacles) {
      auto* surface = std::get_if<ObstacleConfig::Surface>(&o.shape);
      if (surface == nullptr) continue;
      const fs::path file(surface->file.value);
      if (!file.empty() && file.is_relative()) surface->file.value = (input.parent_path() / file).string();
    }
  }
  if (config.output.directory.empty()) config.output.directory = (fs::path("out") / input.stem()).string();
  if (const InputNode* every = given(root, {"output", "every"})) config.output.every_where = every->where;
  complete_time(config.time, root);
  place_whole_mesh_parts(config.bodies);
  place_whole_mesh_parts(config.loads);
}

void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  check_time(config.time, root, diagnostics);
  check_bodies(config, root, diagnostics);
  check_volumetric(config, root, diagnostics);
  check_held(config, root, diagnostics);
  check_names(config, root, diagnostics);
  check_contact(config, root, diagnostics);
  check_tolerances(config, root, diagnostics);
  check_linear_solver(config, root, diagnostics);
}

}  // namespace pliant
