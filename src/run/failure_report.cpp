#include "run/failure_report.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr double nearly_flat = 0.1;    // J of a tetrahedron that has lost nine tenths of its volume
constexpr double poor_quality = 0.1;   // mean ratio
constexpr double nearly_there = 1e2;   // residual over tolerance
constexpr double still_falling = 0.7;  // residual over the previous one

/// A number as YAML writes it.
std::string number(double x) {
  if (std::isnan(x)) return ".nan";
  if (std::isinf(x)) return x > 0.0 ? ".inf" : "-.inf";
  return fmt::format("{:.6g}", x);
}

std::string numbers(std::span<const double> values) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "" : ", ") + number(x);
  return "[" + text + "]";
}

/// A YAML string: every JSON string is one.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

const char* name_of(NewtonIteration::Hessian hessian) {
  switch (hessian) {
    case NewtonIteration::Hessian::exact:
      return "exact";
    case NewtonIteration::Hessian::projected:
      return "projected";
    case NewtonIteration::Hessian::shifted:
      break;
  }
  return "shifted";
}

/// Whether the last iterations have lowered the residual one after the other, to the least of all.
bool is_falling(std::span<const NewtonIteration> iterations) {
  constexpr std::size_t last = 4;
  const auto newest = iterations.last(std::min(iterations.size(), last));
  return std::ranges::is_sorted(newest, std::ranges::greater{}, &NewtonIteration::residual) &&
         std::ranges::min(iterations, {}, &NewtonIteration::residual).residual == iterations.back().residual;
}

void add_newton(const FailedStage& stage, std::string& text) {
  const double scale = stage.force_scale;
  const bool lowers_potential = stage.measure == FailedStage::Measure::potential;
  auto out = std::back_inserter(text);
  fmt::format_to(out, "\nstage: {{time: {}, length: {}}}  # of the method, within the step\n", number(stage.time),
                 number(stage.dt));
  fmt::format_to(out, "newton:\n  lowers: {}\n", lowers_potential ? "potential" : "merit of the residual");
  fmt::format_to(out, "  tolerance: {}       # the residual at which it would have converged [N]\n",
                 number(stage.tolerance));
  fmt::format_to(out, "  force_scale: {}     # the forces that balance; 0: the first guess is beyond a barrier [N]\n",
                 number(scale));
  fmt::format_to(out, "  rounding_floor: {}  # size of the residual's rounding errors [N]\n",
                 number(stage.rounding_floor));
  fmt::format_to(out, "  iterations:  # the first is the guess; residual [N], and over force_scale{}\n",
                 stage.iterations.empty() ? "; there was none" : "");
  for (const auto& it : stage.iterations) {
    fmt::format_to(out, "    - {{residual: {}, relative: {}, step_length: {}, linear_iterations: {}, hessian: {}}}\n",
                   number(it.residual), number(it.residual / scale), number(it.step_length), it.linear_iterations,
                   name_of(it.hessian));
  }
  if (stage.profile.empty()) return;
  fmt::format_to(out, "\n# The function to be lowered, along the last Newton direction from the last iterate.\n");
  fmt::format_to(out, "line:\n  inversion: {}  # length at which a tetrahedron becomes flat\n",
                 number(stage.inversion));
  if (stage.slope) {
    fmt::format_to(out,
                   "  slope: {}  # from the residual: the slope of the profile at 0, unless rounding hides it [J]\n",
                   number(*stage.slope));
  }
  fmt::format_to(out, "  profile:  # length 1 is the full Newton step; change [J]\n");
  for (const auto& [length, change] : stage.profile) {
    fmt::format_to(out, "    - {{length: {}, change: {}}}\n", number(length), number(change));
  }
}

/// What follows an unstable state better than the analysis of the run; empty: none does.
std::string other_analyses(const FailureReport& report) {
  if (report.has_load_steps) return ", or a dynamic analysis instead of load steps";
  if (!report.is_quasistatic) return "";
  std::string text = "; there may be no equilibrium near by at this load: a method with inertia shows where it leads";
  if (!report.has_contact) text += ", 'method: static' with time.path follows the equilibria past a limit point";
  return text;
}

}  // namespace

std::vector<std::string> advice(const FailureReport& report, const Failure& failure) {
  if (failure.is_input_error) return {"another formula, or an earlier time.end"};
  std::vector<std::string> result;
  const auto* stage = failure.stage ? &*failure.stage : nullptr;
  const auto* iterations = stage != nullptr && !stage->iterations.empty() ? &stage->iterations : nullptr;
  if (stage != nullptr && stage->lacks_memory) {
    return {"more memory per rank (fewer ranks on a machine, more machines), solver.linear: amg, a coarser mesh"};
  }
  if (failure.reason.find("nothing holds the bodies") != std::string::npos) {
    return {
        "joints, constraints or a weak `spring` that hold the bodies, a start at which they touch what stops them, or "
        "a method with inertia"};
  }
  if (!report.load_at_once.empty()) {
    result.push_back(fmt::format("the load at {} acts at once in its full size: let it grow, as {}",
                                 report.load_at_once, report.grown_load));
  }
  if (!report.doubt_about_units.empty()) {
    result.push_back(fmt::format("units of the material: {}", report.doubt_about_units));
  }
  const auto is_changed = [](const NewtonIteration& it) { return it.hessian != NewtonIteration::Hessian::exact; };
  if (report.has_load_steps && iterations != nullptr && std::ranges::any_of(*iterations, is_changed)) {
    result.push_back(
        fmt::format("the stiffness is not positive definite, so there may be no equilibrium near by at this load: {}, "
                    "and a prescribed motion or a cavity's liquid holds what a force cannot",
                    report.has_contact ? "a body that contact alone holds may slide or roll, which friction, a "
                                         "constraint or a weak `spring` prevents and a method with inertia follows"
                                       : "time.path follows the equilibria past a limit point"));
  }
  const bool is_unsettled = failure.reason.find("friction did not settle") != std::string::npos;
  if (is_unsettled) {
    result.emplace_back(
        "normal forces jump between one solve and the next, as where edges of two meshes lie over one another, or "
        "friction jams what moves: contact.friction_update: frozen, contact.law: barrier, or other meshes there");
  }
  const bool is_whole = !report.worst_cells.empty() && report.worst_cells.front().volume_ratio > nearly_flat;
  if (stage != nullptr && stage->force_scale == 0.0 && is_whole && !report.has_barriers) {
    result.push_back(
        fmt::format("no starting guess fulfils the prescribed motions: {}, slower motions, or formulas "
                    "without jumps",
                    report.shorter_steps));
  } else if (stage != nullptr && stage->force_scale == 0.0 && is_whole) {
    result.push_back(
        fmt::format("no starting guess is clear of all barriers: {}, slower obstacles, or contact.law: penalty",
                    report.shorter_steps));
  } else if (stage != nullptr && stage->force_scale == 0.0) {
    result.push_back(
        fmt::format("the prescribed motion alone inverts tetrahedra: {}, or a coarser mesh at the moving surface",
                    report.shorter_steps));
  } else if (!report.worst_cells.empty() && !is_whole) {
    result.push_back(fmt::format(
        "tetrahedra are nearly flat: a weaker or slower load there, a finer or better mesh, {}", report.shorter_steps));
  }
  if (!report.worst_cells.empty() && report.worst_cells.front().reference_quality < poor_quality) {
    result.emplace_back("the worst tetrahedron has a poor shape in the mesh already: a better mesh there");
  }
  if (iterations != nullptr) {
    const double last = iterations->back().residual;
    const auto num_iterations = static_cast<int>(iterations->size()) - 1;
    const double before = num_iterations > 0 ? (*iterations)[iterations->size() - 2].residual : last;
    if (num_iterations >= report.max_iterations && last < still_falling * before && is_falling(*iterations)) {
      result.emplace_back("the residual was still falling: a larger solver.newton.max_iterations");
    }
    if (last < nearly_there * stage->tolerance && !is_unsettled) {
      result.push_back(fmt::format("the residual was nearly small enough: solver.newton.relative above {:.1g}",
                                   last / stage->force_scale));
    }
    const auto is_unstable = [](const NewtonIteration& it) { return it.hessian != NewtonIteration::Hessian::exact; };
    if (2 * std::ranges::count_if(*iterations, is_unstable) > num_iterations) {
      result.push_back(fmt::format("the state is unstable (buckling, strong compression): {}{}", report.shorter_steps,
                                   other_analyses(report)));
    }
  }
  result.push_back(fmt::format("{}, weaker or slower loads, a finer or better mesh", report.shorter_steps));
  return result;
}

std::string to_yaml(const FailureReport& report, const Failure& failure) {
  std::string text =
      "# Why a run of Pliant could not continue. SI units. Row numbers refer to state.h5 and start at 0.\n";
  auto out = std::back_inserter(text);
  fmt::format_to(out, "title: {}\ninput: {}\nreason: {}\nadvice:\n", quoted(report.title), quoted(report.file),
                 quoted(failure.reason));
  for (const auto& line : advice(report, failure)) fmt::format_to(out, "  - {}\n", quoted(line));
  fmt::format_to(out, "last_good: {{step: {}, time: {}}}  # in a static problem, time is the load factor\n",
                 report.last_step, number(report.last_time));
  fmt::format_to(out, "tried: {{time: {}, length: {}}}     # the shortest step\n", number(failure.tried.time),
                 number(failure.tried.dt));
  const double scale = failure.stage ? failure.stage->force_scale : 0.0;
  fmt::format_to(out, "\nbodies:  # residual over their nodes [N], also relative to the forces that balance\n");
  for (const auto& body : report.bodies) {
    fmt::format_to(out, "  - {{name: {}, residual: {}, relative: {}, volume_ratio: {}}}\n", quoted(body.name),
                   number(body.residual), number(body.residual / scale), number(body.volume_ratio));
  }
  const auto name_of_body = [&](std::size_t body) { return quoted(report.bodies[body].name); };
  fmt::format_to(out,
                 "\n# Least det F, shape (1 regular, 0 flat) now and in the mesh, middle in the mesh [m], vertices by "
                 "their numbers in the mesh.\nworst_cells:\n");
  for (const auto& cell : report.worst_cells) {
    fmt::format_to(out,
                   "  - {{volume_ratio: {}, quality: {}, reference_quality: {}, body: {}, position: {}, row: {}, "
                   "vertices: [{}]}}\n",
                   number(cell.volume_ratio), number(cell.quality), number(cell.reference_quality),
                   name_of_body(cell.body), numbers(cell.X), cell.row, fmt::join(cell.vertices, ", "));
  }
  if (!failure.stage) {
    text += "\n# The solver reports no further details.\n";
    return text;
  }
  fmt::format_to(out, "\nworst_nodes:  # vertex: number in the mesh, -1 in the middle of an edge\n");
  for (const auto& node : report.worst_nodes) {
    fmt::format_to(out, "  - {{residual: {}, body: {}, position: {}, row: {}, vertex: {}}}\n", number(node.residual),
                   name_of_body(node.body), numbers(node.X), node.row, node.number);
  }
  add_newton(*failure.stage, text);
  return text;
}

}  // namespace pliant
