#include "command/report.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "command/report_page.hpp"
#include "input/output_fields.hpp"
#include "input/parse.hpp"
#include "io/history_reader.hpp"
#include "io/packed_result.hpp"
#include "petsc/collective.hpp"
#include "run/result_fields.hpp"
#include "run/summary.hpp"
#include "run/version.hpp"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include <fmt/chrono.h>
#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t most_rows = 4000;  // rows of the history; a plot has fewer columns of pixels

/// The text of a file; empty if there is none.
std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The page under construction: large data are in elements of their own, identified by number.
class Page {
 public:
  int block(const std::string& text) {
    blocks_ += fmt::format("<script type=\"text/plain\" id=\"block-{}\">{}</script>\n", count_, text);
    return count_++;
  }

  std::string filled(std::string_view page, const Json& report) const {
    constexpr std::string_view place = "<!-- the report -->";
    // No "<" in the text of a script: "</script" would end it.
    std::string text;
    for (const char c : report.dump(-1, ' ', false, Json::error_handler_t::replace)) {
      text += c == '<' ? std::string("\\u003c") : std::string(1, c);
    }
    std::string result(page);
    const auto at = result.find(place);
    if (at == std::string::npos) throw FileError("the viewer of this program is damaged: it has no place for a report");
    return result.replace(
        at, place.size(),
        fmt::format("<script type=\"application/json\" id=\"report\">{}</script>\n{}", text, blocks_));
  }

 private:
  std::string blocks_;
  int count_ = 0;
};

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
  for (const auto& scale : field.scales) json["scales"].push_back(json_of(scale));
  for (const auto& of_mesh : field.values) {
    Json blocks = Json::array();
    for (const auto& text : of_mesh) blocks.push_back(page.block(text));
    json["values"].push_back(blocks);
  }
  return json;
}

Json json_of(const PackedResult& result, Page& page) {
  Json json{{"bodies", result.body_names},
            {"unseen", result.unseen_bodies},
            {"nodes", result.num_nodes},
            {"cells", result.num_cells},
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

/// Every n-th row, and the last one; for iterations the largest of the rows that each stands for.
Json json_of(const HistoryTable& history, Page& page) {
  const std::size_t rows = history.num_rows(), every = std::max<std::size_t>(1, (rows + most_rows - 1) / most_rows);
  Json json{{"columns", history.names}, {"every", every}, {"steps", rows == 0 ? 0 : rows - 1}};
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i + 1 < rows; i += every) kept.push_back(i);
  if (rows > 0) kept.push_back(rows - 1);
  std::vector<double> values;
  for (std::size_t c = 0; c < history.names.size(); ++c) {
    const bool counts = history.names[c].ends_with("_iterations");
    for (std::size_t k = 0; k < kept.size(); ++k) {
      const auto last = history.columns[c].begin() + static_cast<std::ptrdiff_t>(kept[k]);
      const auto first = k > 0 ? history.columns[c].begin() + static_cast<std::ptrdiff_t>(kept[k - 1]) + 1 : last;
      values.push_back(counts ? *std::max_element(first, last + 1) : *last);
    }
  }
  json["rows"] = kept.size();
  json["values"] = page.block(packed_text(std::as_bytes(std::span(values))));
  return json;
}

/// The columns of the history that are taken from fields, with their titles and units.
Json columns_from_fields(const std::string& input) {
  Json columns = Json::array();
  Diagnostics ignored;
  const InputNode root = parse_yaml(input, "run.yaml", ignored);
  const InputNode* list = given(root, {"output", "history"});
  if (list == nullptr) return columns;
  for (const InputNode& entry : list->children) {
    const auto text = [&](const char* key) {
      const InputNode* value = given(entry, {key});
      return value == nullptr ? std::string() : value->text;
    };
    const std::string take = text("take");
    const auto of = field_component(text("of"));
    const bool is_field_itself = take == "max" || take == "min" || take == "mean";  // others have a power of the metre
    columns.push_back({{"column", text("name")},
                       {"title", fmt::format("{} of {}{}", take, text("of"),
                                             text("in").empty() ? "" : fmt::format(" in {}", text("in")))},
                       {"unit", of && is_field_itself ? unit_of_field(of->field.name) : ""}});
  }
  return columns;
}

/// The summary for the terminal.
std::string write_page(const fs::path& file, const ReportOptions& options) {
  const std::string_view viewer = report_page();
  if (viewer.empty()) {
    throw FileError(
        "this program was built without the viewer of reports: npm was missing or could not reach its registry, or "
        "PLIANT_REPORT was off; correct that, touch src/viewer/package.json and build again");
  }
  const fs::path directory = file.parent_path();
  const fs::path output = options.output.empty() ? directory / "report.html" : fs::path(options.output);
  std::optional<ResultReader> result;
  naming(file, [&] { result.emplace(file); });
  Page page;
  Json report{{"format", 1}, {"title", result->title()}, {"directory", fs::absolute(file).parent_path().string()}};
  report["written"] = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
  report["program"] = version_text();
  report["history"] = json_of(read_history(directory / "history.csv"), page);
  report["input"] = text_of(directory / "run.yaml");
  report["taken"] = columns_from_fields(text_of(directory / "run.yaml"));
  report["summary"] = summary_json(directory);
  const double left = options.megabytes * 1e6 - static_cast<double>(page.filled(viewer, report).size());
  PackedResult packed;
  naming(file, [&] { packed = pack_result(*result, static_cast<std::size_t>(std::max(left, 0.0))); });
  report["result"] = json_of(packed, page);
  std::string text = page.filled(viewer, report);
  write_text_atomically(output, text);
  const double size = static_cast<double>(text.size()) * 1e-6;
  return fmt::format("{}: {:.1f} MB, {} of {} frames{}; open it in a browser", output.string(), size,
                     packed.frames.size(), packed.num_frames,
                     size > options.megabytes ? " (the data besides the frames need this much)" : "");
}

}  // namespace

void report_command(MPI_Comm comm, const ReportOptions& options, Console& console) {
  std::string line;
  on_root(comm, [&] {
    const std::filesystem::path file = result_file(options.place);
    line = hdf5_in_child(file, [&] { return write_page(file, options); });
  });
  console.print(line);
}

}  // namespace pliant
