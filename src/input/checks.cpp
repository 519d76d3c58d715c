#include "input/checks.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "input/checks/output.hpp"
#include "input/checks/rigid_bodies.hpp"
#include "input/checks/rods.hpp"
#include "input/checks/shells.hpp"
#include "input/checks/tendons.hpp"
#include "input/checks/time.hpp"
#include "input/checks/volumetric.hpp"
#include "input/elasticity.hpp"
#include "input/keys.hpp"
#include "input/loads.hpp"

#include <algorithm>

namespace pliant {
namespace {

/// The entry of a list of the input.
const InputNode& entry(const InputNode& root, std::string_view list, std::size_t index) {
  return given(root, {list})->children[index];
}

std::string numbered(const std::string& list, std::size_t index) {
  return list + "[" + std::to_string(index) + "]";
}

bool is_known(const MethodConfig& method) {
  return !std::holds_alternative<MethodConfig::Unknown>(method.kind);
}

bool may_overlap(const Selection& a, const Selection& b) {
  return a.kind == Selection::Kind::everything || b.kind == Selection::Kind::everything || a.name == b.name;
}

bool damps_by_mass(const ViscosityConfig& mechanism) {
  return std::holds_alternative<MassProportional>(mechanism.law);
}

/// Rigid bodies without a mesh, and rods, need neither a mesh nor other bodies; free shells need no other bodies.
void check_parts(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const bool has_mesh = root.find("mesh") != nullptr || root.find("bodies") != nullptr;
  const bool has_free_shells = std::ranges::any_of(config.shells, &ShellConfig::is_free);
  if (!(config.rigid_bodies.empty() && config.rods.empty()) && !has_mesh && !has_free_shells) return;
  for (const char* key : {"mesh", "bodies"}) {
    if (has_free_shells && key == std::string_view("bodies")) continue;
    if (given(root, {key}) != nullptr) continue;
    const InputNode* empty = root.find(key);
    if (empty != nullptr) {
      diagnostics.add(empty->key_where, "key '" + std::string(key) + "' has no value");
    } else {
      diagnostics.add({root.where, {key}}, root.where, "missing key '" + std::string(key) + "'");
    }
  }
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
    const auto& elasticity = bodies[i].elasticity;
    for (const auto& [key, held] : {std::pair{"attached", &bodies[i].attached}, {"coupled", &bodies[i].coupled}}) {
      if (bodies[i].is_rigid || held->empty()) continue;
      diagnostics.add(
          held->front().where,
          "'" + std::string(key) + "' is for rigid bodies, which hold surfaces of others: add 'rigid: true'");
    }
    if (bodies[i].is_rigid) {
      for (const char* key : {"elasticity", "viscosity", "active", "expansion", "mullins"}) {
        const InputNode* node = given(entry(root, "bodies", i), {key});
        if (node == nullptr) continue;
        diagnostics.add(node->where,
                        numbered("bodies", i) + " is rigid: remove '" + std::string(key) + "', or say 'rigid: false'");
      }
    } else if (!elasticity && given(entry(root, "bodies", i), {"elasticity"}) == nullptr) {
      diagnostics.add({bodies[i].where, {"elasticity", "rigid"}}, bodies[i].where,
                      "missing key 'elasticity' in " + numbered("bodies", i));
    }
    if (active && active->fibre.empty() && elasticity && elasticity->directions.empty()) {
      diagnostics.add({active->where, {"fibre"}}, active->where,
                      "missing key 'fibre' in active: the elastic law has no fibres of its own");
    }
    if (bodies[i].density || given(entry(root, "bodies", i), {"density"}) != nullptr) continue;
    const Analysis analysis = analysis_of(config);
    const std::string library = elasticity ? elasticity->library : "";
    const std::string unknown = library.empty() ? "" : ": the library does not know that of '" + library + "'";
    const auto is_needed_by = [&](const std::string& what) {
      diagnostics.add({bodies[i].where, {"density"}}, bodies[i].where,
                      "missing key 'density' in " + numbered("bodies", i) + ", which " + what + " needs" + unknown);
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

/// Viscosities relative to the elastic law's two moduli at rest, which laws with fibres do not have.
void check_moduli(const Config& config, Diagnostics& diagnostics) {
  if (analysis_of(config) == Analysis::static_equilibrium) return;
  for (const BodyConfig& body : config.bodies) {
    if (!body.elasticity || !has_fibres(*body.elasticity)) continue;
    for (const ViscosityConfig& mechanism : body.viscosity) {
      const bool needs_moduli = std::holds_alternative<MaxwellRatios>(mechanism.law) ||
                                std::holds_alternative<StiffnessProportional>(mechanism.law);
      if (!needs_moduli) continue;
      diagnostics.add(
          mechanism.where,
          "this viscosity is relative to the shear and bulk modulus at rest, and an elastic law with fibres "
          "has more moduli than these; give a viscosity in absolute numbers");
    }
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
}

void check_barrier(const Config& config, const InputNode& contact, Diagnostics& diagnostics) {
  if (!is_known(config.time.method) || analysis_of(config) != Analysis::dynamic) return;
  if (const Method* own = method_of(config.time); own != nullptr && own->stiffly_accurate) return;
  const auto refuse = [&](const Location& where) {
    diagnostics.add(where,
                    "a barrier needs a stiffly accurate method, whose steps end with their last stage; with '" +
                        method_name(config.time.method) +
                        "' a body could end beyond the barrier: choose backward-euler, bdf2, bdf3, dirk22 or dirk33, "
                        "or 'law: penalty'");
  };
  const InputNode* law = given(contact, {"law"});
  if (config.contact->pressure.law == NormalKind::barrier && law != nullptr) refuse(law->where);
  for (const ContactPairConfig& pair : config.contact->pairs.list) {
    if (pair.law == NormalKind::barrier) refuse(pair.where);
  }
}

/// A surface that passes into itself has no inside.
void check_self_contact(const Config& config, Diagnostics& diagnostics) {
  for (const ContactPairConfig& pair : config.contact->pairs.list) {
    if (pair.part.value.empty()) continue;  // an error already
    if (pair.with || config.contact->law_of(&pair) == NormalKind::barrier) continue;
    diagnostics.add(pair.where,
                    "contact of a part with itself needs 'law: barrier': a penalty lets surfaces pass into "
                    "each other, and a body has no outside within itself");
  }
}

void check_contact_start(const Config& config, const InputNode& contact, Diagnostics& diagnostics) {
  const InputNode* start = given(contact, {"start"});
  if (start == nullptr || config.contact->start == ContactStart::as_meshed || !config.contact->pairs.empty()) return;
  diagnostics.add(start->where, "'start: resolve' moves bodies apart that may touch each other: add 'pairs'");
}

/// Obstacles and pairs of bodies have columns in history.csv, as constrained parts have.
void check_contact_names(const Config& config, const InputNode& contact, Diagnostics& diagnostics) {
  std::vector<std::string> names;
  std::vector<Location> places;
  const auto collect = [&](const char* key, const auto& entries, const char* what) {
    const InputNode* list = given(contact, {key});
    if (list == nullptr || list->kind != InputNode::Kind::list) return;
    for (std::size_t k = 0; k < entries.size(); ++k) {
      const std::string& name = entries[k].name;
      if (name.empty()) continue;
      const InputNode* node = given(list->children[k], {"name"});
      names.push_back(name);
      places.push_back(node != nullptr ? node->where : entries[k].where);
      const auto has_name = [&](const ConstraintConfig& c) { return (c.name.empty() ? c.part.name : c.name) == name; };
      if (std::ranges::any_of(config.constraints, has_name)) {
        diagnostics.add(places.back(), std::string("the ") + what + " name '" + name +
                                           "' is also the name of a constrained part, and history.csv has columns for "
                                           "both; choose another name");
      }
    }
  };
  collect("obstacles", config.contact->obstacles, "obstacle");
  collect("pairs", config.contact->pairs.list, "contact pair");
  check_unique(names, places, "contact name", diagnostics);
}

void check_contact(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  const InputNode* contact = given(root, {"contact"});
  if (!config.contact) return;
  check_barrier(config, *contact, diagnostics);
  check_self_contact(config, diagnostics);
  check_contact_start(config, *contact, diagnostics);
  check_contact_names(config, *contact, diagnostics);
  const InputNode* obstacles = given(*contact, {"obstacles"});
  if (obstacles == nullptr || obstacles->kind != InputNode::Kind::list) return;
  for (std::size_t k = 0; k < config.contact->obstacles.size(); ++k) {
    const ObstacleConfig& o = config.contact->obstacles[k];
    if (std::holds_alternative<ObstacleConfig::Capsule>(o.shape) &&
        given(obstacles->children[k], {"length"}) == nullptr) {
      diagnostics.add(o.where, "missing key 'length' in " + numbered("obstacles", k) + ", which a capsule needs");
    }
  }
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
  diagnostics.add(linear->where,
                  "p-multigrid coarsens quadratic elements to linear ones; add 'element: P2', or use 'amg'");
}

}  // namespace

void check_combinations(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  check_time(config.time, root, diagnostics);
  check_path(config, diagnostics);
  check_parts(config, root, diagnostics);
  check_bodies(config, root, diagnostics);
  check_rigid_bodies(config, diagnostics);
  check_tendons(config, diagnostics);
  check_rods(config, diagnostics);
  check_shells(config, diagnostics);
  check_moduli(config, diagnostics);
  check_volumetric(config, root, diagnostics);
  check_names(config, root, diagnostics);
  check_contact(config, root, diagnostics);
  check_output(config, root, diagnostics);
  check_tolerances(config, root, diagnostics);
  check_linear_solver(config, root, diagnostics);
}

bool is_held_by_springs_or_joints(const Config& config) {
  // The directions in which springs hold depend on the mesh.
  const auto is_spring = [](const LoadConfig& load) {
    const auto foundation = foundation_of(load);
    return foundation && foundation->spring > 0.0;
  };
  const auto pulls_to_ground = [](const SpringConfig& spring) {
    return spring.stiffness > 0.0 &&
           std::ranges::find(spring.points, "ground", &BodyPoint::body) != spring.points.end();
  };
  const auto is_anchored = [](const TendonConfig& tendon) {
    return std::ranges::find(tendon.points, "ground", &BodyPoint::body) != tendon.points.end();
  };
  const auto holds = [](const JointConfig& joint) {
    return std::ranges::find(joint.between, "ground") != joint.between.end();
  };
  const auto is_clamped = [](const RodConfig& rod) { return rod.holder(0) == "ground" || rod.holder(1) == "ground"; };
  return std::ranges::any_of(config.loads, is_spring) || std::ranges::any_of(config.springs, pulls_to_ground) ||
         std::ranges::any_of(config.tendons, is_anchored) || std::ranges::any_of(config.joints, holds) ||
         std::ranges::any_of(config.rods, is_clamped);
}

void check_held(const Config& config, const InputNode& root, Diagnostics& diagnostics) {
  if (analysis_of(config) == Analysis::dynamic) return;
  const std::string method = method_name(config.time.method);
  if (config.contact && !config.contact->obstacles.empty()) return;  // on which bodies may lie (model/checks)
  if (is_held_by_springs_or_joints(config)) return;
  const InputNode* constraints = given(root, {"constraints"});
  const Location& where = config.time.method.where;
  const std::string cure =
      config.contact ? "; contact of bodies with one another does not count: a weak `spring` on a surface holds them"
                     : "";
  if (constraints == nullptr || constraints->children.empty()) {
    diagnostics.add({root.where, {"constraints"}}, where,
                    "a " + method + " analysis needs constraints; without them the bodies can move as a whole" + cure);
    return;
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto is_free = [&](const InputNode& constraint) {
      // These relate displacements to one another alone.
      if (given(constraint, {"periodic_with"}) != nullptr || given(constraint, {"tied_to"}) != nullptr) return true;
      const InputNode* displacement = given(constraint, {"displacement"});
      if (displacement == nullptr) displacement = given(constraint, {"rigid", "translation"});
      return displacement != nullptr && displacement->children.size() == 3 &&
             displacement->children[axis].text == "free";
    };
    if (std::all_of(constraints->children.begin(), constraints->children.end(), is_free)) {
      diagnostics.add(where, "a " + method + " analysis needs a constraint in every direction; none holds " +
                                 std::string(1, "xyz"[axis]) + cure);
    }
  }
}

}  // namespace pliant
