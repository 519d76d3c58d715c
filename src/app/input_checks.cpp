#include "app/input_checks.hpp"

#include "app/input_schema.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>

namespace pliant {
namespace {

constexpr double min_step_divisor = 1024;  // ten halvings
constexpr double most_steps = 1e9;         // steps are counted in an int

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

void check_time(const TimeConfig& time, const InputNode& root, Problems& problems) {
  const InputNode* section = given(root, {"time"});
  if (section == nullptr || section->kind != InputNode::Kind::map || time.method.value.empty()) return;
  if (time.method.value == static_method) return;
  for (const char* key : {"step", "end"}) {
    if (given(*section, {key}) == nullptr) {
      problems.add(section->where, "missing key '" + std::string(key) + "' in time");
    }
  }
  const InputNode* step = given(*section, {"step"});
  const InputNode* end = given(*section, {"end"});
  if (step == nullptr || end == nullptr || time.step <= 0) return;
  const std::string step_text = format_number(time.step) + " s";
  if (time.step > time.end) {
    problems.add(step->where, "the step of " + step_text + " is longer than the simulation, which ends at " +
                                  format_number(time.end) + " s");
  } else if (time.end / time.step > most_steps) {
    problems.add(step->where, "the step of " + step_text + " would need " + format_number(time.end / time.step) +
                                  " steps to the end; at most " + format_number(most_steps) + " are possible");
  }
  const InputNode* min_step = given(*section, {"min_step"});
  if (min_step != nullptr && time.min_step > time.step) {
    problems.add(min_step->where, "'min_step' is larger than the step of " + step_text);
  }
}

bool may_overlap(const Selection& a, const Selection& b) {
  return a.kind == Selection::Kind::everything || b.kind == Selection::Kind::everything || a.name == b.name;
}

void check_bodies(const Config& config, const InputNode& root, Problems& problems) {
  const auto& bodies = config.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!may_overlap(bodies[i].part, bodies[j].part)) continue;
      problems.add(bodies[i].part.where, numbered("bodies", i) + " and " + numbered("bodies", j) +
                                             " fill the same volume; give each a 'volume' of its own");
      break;
    }
    if (given(entry(root, "bodies", i), {"density"}) != nullptr) continue;
    const std::string& method = config.time.method.value;
    const std::string missing = "missing key 'density' in " + numbered("bodies", i);
    const auto pulls = [&](const LoadConfig& l) {
      return l.kind == LoadConfig::Kind::gravity && may_overlap(l.part, bodies[i].part);
    };
    if (!method.empty() && method != static_method && method != quasistatic_method) {
      problems.add(bodies[i].where, missing + ", which dynamics needs");
    } else if (std::any_of(config.loads.begin(), config.loads.end(), pulls)) {
      problems.add(bodies[i].where, missing + ", which gravity needs");
    }
  }
}

/// Without inertia, every direction needs a constraint against moving as a whole.
void check_held(const Config& config, const InputNode& root, Problems& problems) {
  const std::string& method = config.time.method.value;
  if (method != static_method && method != quasistatic_method) return;
  const InputNode* constraints = given(root, {"constraints"});
  const Location& where = config.time.method.where;
  if (constraints == nullptr || constraints->children.empty()) {
    problems.add(where, "a " + method + " analysis needs constraints; without them the bodies can move as a whole");
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_free = [&](const InputNode& constraint) {
      const InputNode* displacement = given(constraint, {"displacement"});
      return displacement != nullptr && displacement->children.size() == 3 &&
             displacement->children[axis].text == "free";
    };
    if (std::all_of(constraints->children.begin(), constraints->children.end(), is_free)) {
      problems.add(where, "a " + method + " analysis needs a constraint in every direction; none holds " +
                              std::string(1, "xyz"[axis]));
    }
  }
}

/// Entries of a list that must differ.
void check_unique(const std::vector<std::string>& values, const std::vector<Location>& places, const std::string& what,
                  Problems& problems) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(i);
    if (values[i].empty() || std::find(values.begin(), end, values[i]) == end) continue;
    problems.add(places[i], "the " + what + " '" + values[i] + "' is given twice");
  }
}

void check_names(const Config& config, const InputNode& root, Problems& problems) {
  std::vector<std::string> names;
  std::vector<Location> places;
  for (std::size_t i = 0; i < config.probes.size(); ++i) {
    const InputNode* name = given(entry(root, "probes", i), {"name"});
    names.push_back(config.probes[i].name);
    places.push_back(name != nullptr ? name->where : config.probes[i].where);
  }
  check_unique(names, places, "probe name", problems);

  const InputNode* fields = given(root, {"output", "fields"});
  if (fields == nullptr || fields->kind != InputNode::Kind::list) return;
  places.clear();
  for (const InputNode& f : fields->children) places.push_back(f.where);
  check_unique(config.output.fields, places, "field", problems);
}

void check_tolerances(const Config& config, const InputNode& root, Problems& problems) {
  const InputNode* relative = given(root, {"solver", "newton", "relative"});
  if (relative == nullptr || parse_number(relative->text) != 0.0 || config.solver.newton.absolute > 0) return;
  problems.add(relative->where, "one of 'relative' and 'absolute' in newton must be above 0");
}

template <class Entries>
void place_whole_mesh_parts(Entries& entries) {
  for (auto& e : entries) {
    if (e.part.kind == Selection::Kind::everything) e.part.where = e.where;
  }
}

}  // namespace

void complete(Config& config, const InputNode& root) {
  namespace fs = std::filesystem;
  const fs::path input(config.file);
  const fs::path mesh(config.mesh.file.value);
  if (!mesh.empty() && mesh.is_relative()) config.mesh.file.value = (input.parent_path() / mesh).string();
  if (config.output.directory.empty()) config.output.directory = (fs::path("out") / input.stem()).string();
  if (given(root, {"time", "min_step"}) == nullptr) config.time.min_step = config.time.step / min_step_divisor;
  place_whole_mesh_parts(config.bodies);
  place_whole_mesh_parts(config.loads);
}

void check(const Config& config, const InputNode& root, Problems& problems) {
  check_time(config.time, root, problems);
  check_bodies(config, root, problems);
  check_held(config, root, problems);
  check_names(config, root, problems);
  check_tolerances(config, root, problems);
}

}  // namespace pliant
