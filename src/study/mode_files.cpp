#include "study/mode_files.hpp"

#include "base/file.hpp"
#include "io/history_writer.hpp"
#include "io/result_writer.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "run/recorder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace pliant {
namespace {

/// The largest displacement that is shown, as a fraction of the size of the bodies.
constexpr double shown_part = 0.1;

/// The largest extent of the bodies [m]. Collective.
double size_of(const NodeLayout& layout) {
  double size = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
      low = std::min(low, layout.position(n)[i]);
      high = std::max(high, layout.position(n)[i]);
    }
    size = std::max(size, maximum(layout.comm, high) - minimum(layout.comm, low));
  }
  return size;
}

/// The largest displacement of a node. Collective.
double largest_of(const NodeLayout& layout, std::span<const double> u) {
  double largest = 0.0;
  for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
    largest = std::max(largest, std::hypot(u[3 * n], u[3 * n + 1], u[3 * n + 2]));
  }
  return maximum(layout.comm, largest);
}

std::string frequency_text(const Mode& mode) {
  switch (mode.kind) {
    case Mode::Kind::rigid:
      return fmt::format("{:>12}  {:>12}", "0", "rigid");
    case Mode::Kind::unstable:
      return fmt::format("{:>12}  {:>12}", "unstable", fmt::format("e^({:.4g} t)", mode.growth_rate));
    case Mode::Kind::vibrates:
      break;
  }
  return fmt::format("{:>12.6g}  {:>12.6g}", mode.frequency, 1.0 / mode.frequency);
}

}  // namespace

std::vector<std::string> mode_table(std::span<const Mode> modes) {
  const bool is_damped = std::ranges::any_of(modes, [](const Mode& mode) { return mode.damping_ratio.has_value(); });
  std::vector<std::string> lines{
      fmt::format("  mode     frequency        period    effective mass [%]{}", is_damped ? "       damping" : ""),
      fmt::format("                 [Hz]           [s]        x       y       z{}", is_damped ? "     ratio" : "")};
  std::array<double, 3> sums{};
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const Mode& mode = modes[i];
    std::string line = fmt::format("  {:>4}  {}  ", i + 1, frequency_text(mode));
    for (std::size_t k = 0; k < 3; ++k) {
      line += fmt::format("  {:>6.2f}", 100.0 * mode.effective_mass[k]);
      sums[k] += mode.effective_mass[k];
    }
    if (mode.damping_ratio) line += fmt::format("  {:>8.3g}", *mode.damping_ratio);
    lines.push_back(std::move(line));
  }
  lines.push_back(fmt::format("  {:>32}    {:>6.2f}  {:>6.2f}  {:>6.2f}", "all of them", 100.0 * sums[0],
                              100.0 * sums[1], 100.0 * sums[2]));
  return lines;
}

void write_modes_csv(MPI_Comm comm, const std::filesystem::path& directory, std::span<const Mode> modes) {
  std::string text = csv_header({"mode", "eigenvalue", "frequency", "growth_rate", "damping_ratio", "effective_mass_x",
                                 "effective_mass_y", "effective_mass_z"}) +
                     '\n';
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const Mode& mode = modes[i];
    const auto [x, y, z] = mode.effective_mass;
    const double none = std::numeric_limits<double>::quiet_NaN();
    text += csv_row(std::array{static_cast<double>(i + 1), mode.eigenvalue, mode.frequency, mode.growth_rate,
                               mode.damping_ratio.value_or(none), x, y, z}) +
            '\n';
  }
  on_root(comm, [&] { write_text_atomically(directory / "modes.csv", text); });
}

void write_mode_frames(const std::filesystem::path& directory, const Config& config, const Model& model, Vec q,
                       std::span<const Mode> modes) {
  const NodeLayout& layout = model.layout();
  ResultWriter result(layout.comm, directory, config.title, output_mesh(config, model));
  const double size = size_of(layout);
  const ConstArrayView state(q);
  std::vector<double> moved(state.span().size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const ConstArrayView shape(modes[i].shape.get());
    const double largest = largest_of(layout, shape.span());
    const double factor = largest > 0.0 ? shown_part * size / largest : 0.0;
    for (std::size_t k = 0; k < moved.size(); ++k) moved[k] = state.span()[k] + factor * shape.span()[k];
    const std::array fields{OutputField{"displacement", "m", FieldLocation::node, 3, moved},
                            OutputField{"mode_shape", "1/sqrt(kg)", FieldLocation::node, 3, shape.span()}};
    const auto number = static_cast<std::int64_t>(i + 1);
    result.write_frame(static_cast<double>(number), number, fields, label_of(modes[i], i + 1));
  }
  result.sync();
}

}  // namespace pliant
