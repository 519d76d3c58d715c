#include "run/summary.hpp"

#include "base/file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

namespace pliant {
namespace {

using Json = nlohmann::ordered_json;

std::filesystem::path file_in(const std::filesystem::path& directory) {
  return directory / "summary.json";
}

}  // namespace

double RunSeconds::rest() const {
  return std::max(0.0, total - (set_up + assembly + factorization + solve + output));
}

void write_summary(const std::filesystem::path& directory, const Summary& summary) {
  const auto& [total, set_up, mesh, assembly, factorization, solve, output] = summary.seconds;
  const SolverStatistics& s = summary.solver;
  Json json{{"outcome", summary.outcome}, {"message", summary.message}, {"ranks", summary.ranks}};
  json["warnings"] = summary.warnings;
  json["notes"] = summary.notes;
  json["seconds"] = {{"total", total},
                     {"set_up", set_up},
                     {"mesh", mesh},
                     {"assembly", assembly},
                     {"factorization", factorization},
                     {"solve", solve},
                     {"output", output},
                     {"rest", summary.seconds.rest()}};
  json["steps"] = {{"accepted", summary.steps.accepted},
                   {"shortest", summary.steps.shortest},
                   {"longest", summary.steps.longest},
                   {"failed", summary.steps.failed},
                   {"inaccurate", summary.steps.inaccurate}};
  json["solver"] = {{"stages", s.stages},
                    {"minimisations", s.minimisations},
                    {"residual_solves", s.residual_solves},
                    {"newton_iterations", s.newton_iterations},
                    {"linear_iterations", s.linear_iterations},
                    {"factorizations", s.factorizations},
                    {"backtracks", s.backtracks},
                    {"capped_steps", s.capped_steps},
                    {"projections", s.projections},
                    {"regularizations", s.regularizations},
                    {"rounding_stops", s.rounding_stops},
                    {"worst_rounding", s.worst_rounding},
                    {"unsettled_stages", s.unsettled_stages},
                    {"worst_unsettled", s.worst_unsettled},
                    {"unstable_stages", s.unstable_stages}};
  if (std::isfinite(summary.steps.least_gap)) json["contact_gap_min"] = summary.steps.least_gap;
  if (summary.worst.newton_iterations >= 0) {
    json["worst_step"] = {{"step", summary.worst.step},
                          {"time", summary.worst.time},
                          {"newton_iterations", summary.worst.newton_iterations}};
  }
  if (const auto& growth = summary.energy_growth) {
    json["energy_growth"] = {{"factor", growth->factor}, {"time", growth->time}};
  }
  if (const auto& watch = summary.mesh_error) {
    const MeshError& error = watch->worst();
    json["discretization_error"] = {
        {"share", error.share}, {"energy", error.energy}, {"time", watch->time()}, {"place", error.place}};
  }
  for (const auto& [step, point] : summary.critical_points) {
    json["critical_points"].push_back(
        {{"kind", name_of(point.kind)}, {"load_factor", point.load_factor}, {"step", step}});
  }
  write_text_atomically(file_in(directory), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

Json summary_json(const std::filesystem::path& directory) {
  std::ifstream file(file_in(directory));
  const Json json = Json::parse(file, nullptr, /*allow_exceptions=*/false);
  return json.is_object() ? json : Json();
}

void remove_summary(const std::filesystem::path& directory) {
  std::error_code ignored;
  std::filesystem::remove(file_in(directory), ignored);
}

}  // namespace pliant
