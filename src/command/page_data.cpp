#include "command/page_data.hpp"

#include "base/error.hpp"
#include "command/report_page.hpp"
#include "io/packed.hpp"
#include "run/version.hpp"

#include <ctime>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace pliant {

void require_viewer() {
  if (!report_page().empty()) return;
  throw FileError(
      "this program was built without the viewer of reports: npm was missing or could not reach its registry, or "
      "PLIANT_REPORT was off; correct that, touch src/viewer/package.json and build again");
}

int Page::block(const std::string& text) {
  blocks_ += fmt::format("<script type=\"text/plain\" id=\"block-{}\">{}</script>\n", count_, text);
  return count_++;
}

int Page::block(std::span<const double> numbers) {
  return block(packed_text(std::as_bytes(numbers)));
}

std::string Page::filled(const Json& report) const {
  constexpr std::string_view place = "<!-- the report -->";
  // No "<" in the text of a script: "</script" would end it.
  std::string text;
  for (const char c : report.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  std::string result(report_page());
  const auto at = result.find(place);
  if (at == std::string::npos) throw FileError("the viewer of this program is damaged: it has no place for a report");
  return result.replace(at, place.size(),
                        fmt::format("<script type=\"application/json\" id=\"report\">{}</script>\n{}", text, blocks_));
}

namespace {

Json json_of(const Quantisation& scale) {
  return {scale.low, scale.high, scale.levels};
}

Json json_of(const PackedMesh& mesh, Page& page) {
  Json json{{"vertices", mesh.num_vertices},
            {"triangles", mesh.num_triangles},
            {"perFacet", mesh.triangles_per_facet},
            {"index", page.block(mesh.triangles)},
            {"bodies", page.block(mesh.bodies)}};
  for (std::size_t i = 0; i < 3; ++i) {
    json["positions"].push_back(page.block(mesh.positions[i]));
    json["scales"].push_back(json_of(mesh.scales[i]));
  }
  return json;
}

Json json_of(const PackedPoints& points, Page& page) {
  Json json{{"vertices", points.count}};
  for (std::size_t i = 0; i < 3; ++i) {
    json["positions"].push_back(page.block(points.positions[i]));
    json["scales"].push_back(json_of(points.position_scales[i]));
    json["moves"].push_back(page.block(points.moves[i]));
    json["moveScales"].push_back(json_of(points.move_scales[i]));
  }
  return json;
}

Json json_of(const PackedObstacles& obstacles, Page& page) {
  if (obstacles.points.count == 0) return nullptr;
  Json json = json_of(obstacles.points, page);
  json["names"] = obstacles.names;
  json["index"] = page.block(obstacles.triangles);
  json["owners"] = page.block(obstacles.owners);
  return json;
}

Json json_of(const PackedMechanisms& mechanisms, Page& page) {
  if (mechanisms.points.count == 0) return nullptr;
  Json json = json_of(mechanisms.points, page);
  json["names"] = mechanisms.names;
  json["kinds"] = mechanisms.kinds;
  json["segments"] = page.block(mechanisms.segments);
  json["parts"] = page.block(mechanisms.parts);
  json["joints"] = page.block(mechanisms.joints);
  json["tensions"] = page.block(mechanisms.tensions);
  json["tensionScale"] = json_of(mechanisms.tension_scale);
  return json;
}

Json json_of(const PackedField& field, Page& page) {
  Json json{{"name", field.name}, {"unit", field.unit}};
  if (!field.absent.empty()) json["absent"] = field.absent;
  for (const auto& scale : field.scales) json["scales"].push_back(json_of(scale));
  for (const auto& of_mesh : field.values) {
    Json blocks = Json::array();
    for (const auto& text : of_mesh) blocks.push_back(page.block(text));
    json["values"].push_back(blocks);
  }
  return json;
}

}  // namespace

Json json_of(const PackedResult& result, Page& page) {
  Json json{{"bodies", result.body_names},
            {"unseen", result.unseen_bodies},
            {"masses", result.masses},
            {"nodes", result.num_nodes},
            {"elements",
             {{"tetrahedra", result.elements.tetrahedra},
              {"triangles", result.elements.triangles},
              {"segments", result.elements.segments}}},
            {"order", result.nodes_per_cell == 10 ? 2 : 1},
            {"framesInResult", result.num_frames}};
  json["meshes"] = json["obstacles"] = json["mechanisms"] = json["frames"] = json["fields"] = Json::array();
  for (const auto& mesh : result.meshes) json["meshes"].push_back(json_of(mesh, page));
  for (const auto& obstacles : result.obstacles) json["obstacles"].push_back(json_of(obstacles, page));
  for (const auto& mechanisms : result.mechanisms) json["mechanisms"].push_back(json_of(mechanisms, page));
  for (const auto& f : result.frames) {
    Json& frame =
        json["frames"].emplace_back(Json{{"time", f.time}, {"step", f.step}, {"mesh", f.mesh}, {"shift", f.shift}});
    if (!f.label.empty()) frame["label"] = f.label;
  }
  for (const auto& field : result.fields) json["fields"].push_back(json_of(field, page));
  return json;
}

void add_origin(Json& report) {
  report["written"] = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
  report["program"] = version_text();
}

}  // namespace pliant
