#include "run/post_mortem.hpp"

#include "base/file.hpp"
#include "fem/deformed_cell.hpp"
#include "input/loads.hpp"
#include "model/warnings.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "run/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t num_reported = 10;

fs::path directory_of(const Config& config) {
  return fs::path(config.output.directory) / "post-mortem";
}

/// The worst of all ranks' rows by `is_worse`, the same on every rank.
template <class Row, class Worse>
std::vector<Row> worst(MPI_Comm comm, std::vector<Row> mine, const Worse& is_worse) {
  const auto keep_worst = [&](std::vector<Row>& rows) {
    const auto middle = rows.begin() + static_cast<std::ptrdiff_t>(std::min(rows.size(), num_reported));
    std::partial_sort(rows.begin(), middle, rows.end(), is_worse);
    rows.erase(middle, rows.end());
  };
  keep_worst(mine);
  std::vector<Row> rows = gathered(comm, mine);
  keep_worst(rows);
  return rows;
}

/// A state of the model as the frames of state.h5 contain it, for owned nodes and cells.
struct Picture {
  std::vector<double> displacement, residual, step;
  std::vector<double> volume_ratio, quality;
  std::vector<DeformedCell> cells;
};

std::vector<double> owned_values(const NodeLayout& layout, Vec x) {
  std::vector<double> values(3 * static_cast<std::size_t>(layout.num_owned_nodes), 0.0);
  if (x != nullptr) std::ranges::copy(ConstArrayView(x).span(), values.begin());
  return values;
}

/// `residual` and `step` may be nullptr: zero.
Picture picture_of(const NodeLayout& layout, Vec q, Vec residual, Vec step) {
  Picture picture{owned_values(layout, q), owned_values(layout, residual), owned_values(layout, step), {}, {}, {}};
  const Handle<Vec> ghosted = make_vector(layout);
  check(VecCopy(q, ghosted.get()));
  update_ghosts(ghosted.get());
  const ConstGhostedView u(ghosted.get());
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    picture.cells.push_back(deformed_cell(layout, c, u.span()));
    picture.volume_ratio.push_back(picture.cells.back().volume_ratio);
    picture.quality.push_back(picture.cells.back().quality);
  }
  return picture;
}

void write_frame(ResultWriter& writer, const Picture& picture, double time, std::int64_t step) {
  using enum FieldLocation;
  const std::vector<OutputField> fields{{"displacement", "m", node, 3, picture.displacement},
                                        {"residual", "N", node, 3, picture.residual},
                                        {"newton_step", "m", node, 3, picture.step},
                                        {"volume_ratio", "", cell, 1, picture.volume_ratio},
                                        {"quality", "", cell, 1, picture.quality}};
  writer.write_frame(time, step, fields);
}

/// NaN is the worst.
double rank_of_ratio(double volume_ratio) {
  return std::isnan(volume_ratio) ? -std::numeric_limits<double>::infinity() : volume_ratio;
}
double rank_of_residual(double residual) {
  return std::isnan(residual) ? std::numeric_limits<double>::infinity() : residual;
}

bool is_of_rod(const Model& model, PetscInt cell) {
  return std::ranges::find(model.rods().rods, model.body_of_cell()[cell], &ModelRod::body) != model.rods().rods.end();
}

/// Whether the cell's shape says something; that of shells and rigid bodies does not.
bool has_shape(const Model& model, PetscInt cell) {
  const auto& with_law = model.bodies_of_elastic();
  return is_of_rod(model, cell) || std::ranges::find(with_law, model.body_of_cell()[cell]) != with_law.end();
}

std::vector<ReportedCell> worst_cells(const Model& model, const Picture& picture) {
  const NodeLayout& layout = model.layout();
  const RowBlock rows = row_block(layout.comm, layout.num_owned_cells);
  std::vector<ReportedCell> cells;
  for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
    const DeformedCell& shape = picture.cells[static_cast<std::size_t>(c)];
    const bool has_one = has_shape(model, c);
    ReportedCell cell{.volume_ratio = has_one ? shape.volume_ratio : 1.0,
                      .quality = has_one ? shape.quality : 1.0,
                      .reference_quality = is_of_rod(model, c) ? 1.0 : shape.reference_quality,  // meant to be slim
                      .body = static_cast<std::size_t>(model.body_of_cell()[c]),
                      .X = shape.X,
                      .row = rows.first + c};
    for (std::size_t a = 0; a < 4; ++a) cell.vertices[a] = layout.vertex_numbers[layout.nodes_of_cell(c)[a]];
    cells.push_back(cell);
  }
  return worst(layout.comm, std::move(cells), [](const ReportedCell& a, const ReportedCell& b) {
    return rank_of_ratio(a.volume_ratio) < rank_of_ratio(b.volume_ratio);
  });
}

/// For each body and owned node, whether the node belongs to the body.
std::vector<std::vector<char>> nodes_of_bodies(const Model& model) {
  const NodeLayout& layout = model.layout();
  std::vector<std::vector<char>> is_in(model.body_names().size(),
                                       std::vector<char>(static_cast<std::size_t>(layout.num_owned_nodes), 0));
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    for (const PetscInt n : layout.nodes_of_cell(c)) {
      if (n < layout.num_owned_nodes) is_in[model.body_of_cell()[c]][n] = 1;
    }
  }
  return is_in;
}

double square(const Picture& picture, PetscInt node) {
  double total = 0.0;
  for (PetscInt i = 3 * node; i < 3 * node + 3; ++i) total += picture.residual[i] * picture.residual[i];
  return total;
}

std::vector<ReportedNode> worst_nodes(const Model& model, const Picture& picture) {
  const NodeLayout& layout = model.layout();
  const auto is_in = nodes_of_bodies(model);
  std::vector<ReportedNode> nodes;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    const auto body = std::ranges::find_if(is_in, [&](const std::vector<char>& of) { return of[n] != 0; });
    nodes.push_back({std::sqrt(square(picture, n)), static_cast<std::size_t>(body - is_in.begin()), layout.position(n),
                     layout.global_node(n), layout.vertex_numbers[n]});
  }
  return worst(layout.comm, std::move(nodes), [](const ReportedNode& a, const ReportedNode& b) {
    return rank_of_residual(a.residual) > rank_of_residual(b.residual);
  });
}

std::vector<ReportedBody> bodies(const Model& model, const Picture& picture) {
  const NodeLayout& layout = model.layout();
  const auto is_in = nodes_of_bodies(model);
  std::vector<ReportedBody> result;
  for (std::size_t body = 0; body < is_in.size(); ++body) {
    double squares = 0.0, least = std::numeric_limits<double>::infinity();
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      if (is_in[body][n] != 0) squares += square(picture, n);
    }
    for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
      if (model.body_of_cell()[c] != static_cast<int>(body)) continue;
      least = std::min(least, has_shape(model, c) ? picture.volume_ratio[c] : 1.0);
    }
    result.push_back({model.body_names()[body], std::sqrt(sum(layout.comm, squares)), minimum(layout.comm, least)});
  }
  return result;
}

std::string where_to_look(const fs::path& directory, const FailureReport& report) {
  const ReportedCell& cell = report.worst_cells.front();
  return fmt::format(
      "{0}/report.yaml says where and how (smallest det F: {1:.3g}, body '{2}' at [{3:.4g}, {4:.4g}, {5:.4g}] m), "
      "`pliant report {0}` and {0}/state.xdmf in ParaView show it (colour by volume_ratio or residual)",
      directory.string(), cell.volume_ratio, report.bodies[cell.body].name, cell.X[0], cell.X[1], cell.X[2]);
}

}  // namespace

std::string write_post_mortem(const Config& config, const Model& model, const StepRecord& last_good,
                              const Failure& failure) {
  const NodeLayout& layout = model.layout();
  const fs::path directory = directory_of(config);
  ResultWriter writer(layout.comm, {directory, "state"}, config.title, output_mesh(config, model));
  Picture picture = picture_of(layout, last_good.q, nullptr, nullptr);
  write_frame(writer, picture, last_good.time, last_good.step);
  FailureReport report;
  if (const auto& stage = failure.stage) {
    picture = picture_of(layout, stage->displacement.get(), stage->residual.get(), stage->direction.get());
    write_frame(writer, picture, failure.tried.time, last_good.step + 1);
    report.worst_nodes = worst_nodes(model, picture);
  }
  writer.sync();
  report.title = config.title;
  report.file = config.file;
  report.last_step = last_good.step;
  report.last_time = last_good.time;
  report.max_iterations = config.solver.newton.max_iterations;
  const bool is_static = analysis_of(config) == Analysis::static_equilibrium;
  report.has_load_steps = is_static && !config.time.path;
  report.is_quasistatic = analysis_of(config) == Analysis::quasistatic;
  const auto sudden = report.is_quasistatic ? load_at_once(config) : std::nullopt;
  if (sudden && last_good.step == 0) {
    report.load_at_once = to_string(sudden->where);
    report.grown_load = sudden->grown;
  }
  report.has_contact = config.contact.has_value();
  report.has_barriers = config.contact && config.contact->has_barrier();
  const auto of_units = warnings_about_units(config);
  if (!of_units.empty()) report.doubt_about_units = to_string(of_units.front());
  report.shorter_steps = is_static              ? "more load_steps"
                         : config.time.adaptive ? "a smaller time.step or time.adaptive.min_step"
                                                : "a smaller time.step or time.min_step";
  report.bodies = bodies(model, picture);
  report.worst_cells = worst_cells(model, picture);
  on_root(layout.comm, [&] { write_text_atomically(directory / "report.yaml", to_yaml(report, failure)); });
  return where_to_look(directory, report) + "; try: " + advice(report, failure).front();
}

void remove_post_mortem(MPI_Comm comm, const Config& config) {
  on_root(comm, [&] {
    std::error_code ignored;
    if (!fs::is_directory(directory_of(config), ignored)) return;
    for (const char* file : {"report.yaml", "state.h5", "state.xdmf", "report.html", "picture.png"})
      fs::remove(directory_of(config) / file, ignored);
    fs::remove(directory_of(config), ignored);
  });
}

}  // namespace pliant
