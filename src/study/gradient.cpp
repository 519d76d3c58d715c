#include "study/gradient.hpp"

#include "base/file.hpp"
#include "base/text.hpp"
#include "io/history_writer.hpp"
#include "io/result_writer.hpp"
#include "model/mesh_cell_data.hpp"
#include "model/mesh_source.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "run/recorder.hpp"
#include "study/adjoint_fields.hpp"
#include "study/adjoint_run.hpp"
#include "study/shape_gradient.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <optional>

#include <fmt/format.h>

namespace pliant {
namespace {

namespace fs = std::filesystem;

/// What part of a derivative may be missing in the sum over the cells: rounding errors.
constexpr double accounted = 1e-4;

std::string option_of(const std::string& name, const std::vector<std::string>& keys) {
  std::string text = name + " ";
  for (const std::string& key : keys) text += (&key == &keys.front() ? "" : ",") + key;
  return text;
}

/// A table on all ranks, its rows sorted by their first numbers.
std::string table_of(MPI_Comm comm, const std::vector<std::string>& names, const std::vector<double>& mine) {
  const std::vector<double> all = gathered(comm, mine);
  const std::size_t width = names.size();
  std::vector<std::size_t> order(all.size() / width);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto row = [&](std::size_t n) { return std::span(all).subspan(n * width, width); };
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return std::ranges::lexicographical_compare(row(a).first(4), row(b).first(4));
  });
  std::string text = csv_header(names) + '\n';
  for (const std::size_t n : order) text += csv_row({row(n).begin(), row(n).end()}) + '\n';
  return text;
}

class GradientStudy {
 public:
  GradientStudy(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                const GradientOptions& options, Console& console)
      : comm_(comm),
        console_(console),
        numbers_(input_text(comm, file), file, changes, options.numbers, option_of("--to", options.numbers)),
        fields_(input_text(comm, file), file, changes, options.fields, option_of("--fields", options.fields)),
        directory_(numbers_.given().output.directory) {
    AdjointWeights weights;
    on_every_rank(comm, [&] { weights = read_adjoint_weights(options.weights); });
    on_root(comm, [&] { make_directory(directory_); });
    const Mesh mesh = mesh_of(numbers_.given());
    auto parameters = fields_.parameters();
    for (std::size_t n = 0; n < numbers_.numbers().size(); ++n) parameters.push_back(parameter(n));
    run_.emplace(mesh, numbers_.given(), weights, parameters, options.kept_steps);
    fields_.find_values(mesh, run_->model());
    for (const auto& diagnostic : run_->model().diagnostics()) console_.report(diagnostic);
  }

  ExitCode operator()() {
    run_->run([&](double time) { console_.progress(fmt::format("t = {:.6g}", time)); });
    run_->go_back([&](double time) { console_.progress(fmt::format("back at t = {:.6g}", time)); });
    require_all_of_fields();
    write();
    print();
    return ExitCode::done;
  }

 private:
  Mesh mesh_of(const Config& config) const { return read_mesh(comm_, mesh_source(config)); }

  AdjointRun::Parameter parameter(std::size_t n) const {
    const VariedNumber& number = numbers_.numbers()[n];
    if (number.value == 0.0) throw without_neighbours(numbers_.file(), number.key);
    const auto make = [this, n](double value) {
      std::vector<double> values;
      for (const VariedNumber& p : numbers_.numbers()) values.push_back(p.value);
      values[n] = value;
      return numbers_.at(values);
    };
    return {number.value, make, false, {}, size_of_number(number.key, number.value)};
  }
  double derivative(std::size_t n) const { return run_->parameter(fields_.num_parameters() + n).derivative(); }

  void require_all_of_fields() const {
    for (std::size_t n = 0; n < fields_.num_parameters(); ++n) {
      if (run_->parameter(n).part_not_of_cells() <= accounted) continue;
      const char* const why =
          n < fields_.num_constants()
              ? "in each cell: not only the law of the body depends on it, but also what is derived from it, such as "
                "the stiffness of contact, a load that varies in space, or velocities that change at once where "
                "constraints begin to move"
              : "at each node: not only cells depend on places in the mesh, but also shells, loads on surfaces, "
                "formulas of x, "
                "y and z, contact, or velocities that change at once where constraints begin to move; leave them out";
      throw InputError({numbers_.file(), 0, 0}, fmt::format("'{}' cannot have a derivative {}", fields_.key(n), why));
    }
  }

  void write() const {
    std::string text = "number,value,unit,derivative\n";
    for (std::size_t n = 0; n < numbers_.numbers().size(); ++n) {
      const VariedNumber& p = numbers_.numbers()[n];
      text += fmt::format("{},{},{},{}\n", p.key, format_number(p.value), p.unit, format_number(derivative(n)));
    }
    write_table("gradient.csv", numbers_.numbers().empty() ? std::string() : text);
    const auto fields = fields_.on_mesh(*run_);
    write_table("gradient_cells.csv", cells(fields));
    write_table("gradient_nodes.csv", nodes(fields));
    if (fields.empty()) return;
    ResultWriter result(comm_, {directory_, "gradient"}, run_->config().title,
                        output_mesh(run_->config(), run_->model()));
    std::vector<OutputField> output;
    for (const AdjointFields::OnMesh& f : fields) output.push_back({f.name, "", f.location, f.components, f.values});
    result.write_frame(0.0, 0, output);
    result.sync();
  }

  void write_table(const std::string& name, const std::string& text) const {
    on_root(comm_, [&] {
      const fs::path file = directory_ / name;
      text.empty() ? static_cast<void>(fs::remove(file)) : write_text_atomically(file, text);
    });
  }

  std::string cells(const std::vector<AdjointFields::OnMesh>& fields) const {
    const NodeLayout& layout = run_->model().layout();
    std::vector<std::string> names{"cell", "x", "y", "z"};
    const auto is_of_cells = [](const AdjointFields::OnMesh& f) { return f.location == FieldLocation::cell; };
    for (const auto& f : fields) {
      if (is_of_cells(f)) names.push_back(f.name);
    }
    if (names.size() == 4) return {};
    std::vector<double> rows;
    for (PetscInt c = 0; c < layout.num_owned_cells; ++c) {
      const auto X = centroid(layout, c);
      rows.push_back(static_cast<double>(layout.cell_numbers[static_cast<std::size_t>(c)]));
      rows.insert(rows.end(), X.begin(), X.end());
      for (const auto& f : fields) {
        if (is_of_cells(f)) rows.push_back(f.values[static_cast<std::size_t>(c)]);
      }
    }
    return table_of(comm_, names, rows);
  }

  std::string nodes(const std::vector<AdjointFields::OnMesh>& fields) const {
    const NodeLayout& layout = run_->model().layout();
    std::vector<std::string> names{"vertex", "x", "y", "z"};
    const auto is_of_nodes = [](const AdjointFields::OnMesh& f) { return f.location == FieldLocation::node; };
    for (const auto& f : fields) {
      if (!is_of_nodes(f)) continue;
      for (const char* component : {"_x", "_y", "_z"}) names.push_back(f.name + component);
    }
    if (names.size() == 4) return {};
    std::vector<double> rows;
    for (PetscInt a = 0; a < layout.num_owned_nodes; ++a) {
      const auto X = layout.position(a);
      rows.push_back(static_cast<double>(layout.vertex_numbers[static_cast<std::size_t>(a)]));
      rows.insert(rows.end(), X.begin(), X.end());
      for (const auto& f : fields) {
        if (!is_of_nodes(f)) continue;
        const auto values = std::span(f.values).subspan(static_cast<std::size_t>(3 * a), 3);
        rows.insert(rows.end(), values.begin(), values.end());
      }
    }
    return table_of(comm_, names, rows);
  }

  void print() const {
    std::size_t width = 6;
    for (const VariedNumber& p : numbers_.numbers()) width = std::max(width, p.key.size());
    for (std::size_t n = 0; n < fields_.num_parameters(); ++n) width = std::max(width, fields_.key(n).size());
    console_.print(
        fmt::format("derivatives of the sum of weights times columns over {} steps, in SI units", run_->num_steps()));
    console_.print(fmt::format("  {:<{}}  {:>13}  {:<8}  {:>16}  {:>16}", "number", width, "value", "unit",
                               "derivative", "for 1 % of it"));
    for (std::size_t n = 0; n < numbers_.numbers().size(); ++n) {
      const VariedNumber& p = numbers_.numbers()[n];
      console_.print(fmt::format("  {:<{}}  {:>13.7g}  {:<8}  {:>16.9g}  {:>16.6g}", p.key, width, p.value,
                                 p.unit == "1" ? "" : p.unit, derivative(n), 0.01 * p.value * derivative(n)));
    }
    for (std::size_t n = 0; n < fields_.num_constants(); ++n) {
      const double relative = run_->parameter(n).derivative() * fields_.value_of_parameter(n);
      console_.print(fmt::format("  {:<{}}  {:>13}  {:<8}  {:>16}  {:>16.6g}", fields_.key(n), width, "of each cell",
                                 "", "", 0.01 * relative));
    }
    if (fields_.by_nodes()) console_.print(fmt::format("  {:<{}}  {:>13}", key_of_nodes, width, "of each node"));
    if (run_->num_repeated() > 0) {
      console_.print(fmt::format("{} of {} steps were computed twice: not all fit into memory at once",
                                 run_->num_repeated(), run_->num_steps()));
    }
    console_.print(fmt::format("results: {}/gradient*", run_->config().output.directory));
  }

  MPI_Comm comm_;
  Console& console_;
  VariedInput numbers_;
  AdjointFields fields_;
  fs::path directory_;
  std::optional<AdjointRun> run_;
};

}  // namespace

ExitCode gradient_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& changes,
                          const GradientOptions& options, Console& console) {
  return GradientStudy(comm, file, changes, options, console)();
}

}  // namespace pliant
