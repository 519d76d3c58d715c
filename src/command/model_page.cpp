#include "command/model_page.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "command/model_items.hpp"
#include "command/page_data.hpp"
#include "input/input.hpp"
#include "io/packed_result.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "run/recorder.hpp"
#include "run/result_fields.hpp"
#include "run/simulation.hpp"

#include <limits>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// A directory for what is needed while the page is written.
class Scratch {
 public:
  /// Throws FileError if it exists, or cannot be made. Collective.
  Scratch(MPI_Comm comm, fs::path directory) : comm_(comm), directory_(std::move(directory)) {
    on_root(comm_, [&] {
      std::error_code error;
      if (directory_.has_parent_path()) fs::create_directories(directory_.parent_path(), error);
      const bool is_new = !error && fs::create_directory(directory_, error);
      if (error) throw FileError(fmt::format("cannot create '{}': {}", directory_.string(), error.message()));
      if (!is_new)
        throw FileError(fmt::format("'{}' is needed while the page is written; remove it", directory_.string()));
    });
  }
  ~Scratch() {
    std::error_code ignored;
    if (rank(comm_) == 0) fs::remove_all(directory_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& directory() const { return directory_; }

 private:
  MPI_Comm comm_;
  fs::path directory_;
};

Json json_of(const ModelItem& item, Page& page) {
  Json json{{"kind", to_string(item.kind)}, {"name", item.name}, {"text", item.text}};
  json["points"] = page.block(std::span<const double>(item.points));
  if (!item.vectors.empty()) json["vectors"] = page.block(std::span<const double>(item.vectors));
  return json;
}

Json json_of(const Diagnostic& diagnostic) {
  const std::string where = to_string(diagnostic.where);
  return {{"severity", diagnostic.severity == Severity::note ? "note" : "warning"},
          {"text", where.empty() ? diagnostic.message : fmt::format("{}: {}", where, diagnostic.message)}};
}

}  // namespace

std::string write_model_page(const Mesh& mesh, const Config& config, Model& model,
                             const std::vector<std::string>& lines, const fs::path& output) {
  require_viewer();
  const MPI_Comm comm = model.layout().comm;
  const Scratch scratch(comm, output.string() + ".start");
  const fs::path result_file = scratch.directory() / "result.h5";
  Config at_start = config;
  at_start.output.directory = scratch.directory().string();
  at_start.output.fields = {"displacement"};
  at_start.output.history.clear();
  const Simulation simulation(at_start, model);
  Recorder recorder(at_start, model, simulation.ledger(), std::nullopt);
  recorder.write_frame(simulation.record());
  recorder.sync();
  const std::vector<ModelItem> items = model_items(mesh, config, model, simulation.record().q);
  std::string line;
  on_root(comm, [&] {
    line = hdf5_in_child(result_file, [&] {
      Page page;
      Json report{{"format", 1}, {"title", config.title.empty() ? config.file : config.title}};
      report["directory"] = fs::absolute(config.file).parent_path().string();
      add_origin(report);
      report["input"] = dump(config);
      Json model_json{{"lines", lines}, {"items", Json::array()}, {"diagnostics", Json::array()}};
      for (const ModelItem& item : items) model_json["items"].push_back(json_of(item, page));
      for (const Diagnostic& diagnostic : model.diagnostics()) model_json["diagnostics"].push_back(json_of(diagnostic));
      report["model"] = model_json;
      const ResultReader result(result_file);
      report["result"] = json_of(pack_result(result, std::numeric_limits<std::size_t>::max()), page);
      const std::string text = page.filled(report);
      write_text_atomically(output, text);
      return fmt::format("{}: {:.1f} MB; open it in a browser", output.string(),
                         1e-6 * static_cast<double>(text.size()));
    });
  });
  return line;
}

}  // namespace pliant
