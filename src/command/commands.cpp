#include "command/commands.hpp"

#include "base/text.hpp"
#include "base/units.hpp"
#include "command/contact_table.hpp"
#include "command/material_plot.hpp"
#include "command/mechanism_table.hpp"
#include "command/model_page.hpp"
#include "command/page_data.hpp"
#include "energy/volume/viscous.hpp"
#include "input/analysis.hpp"
#include "input/elasticity.hpp"
#include "input/keys.hpp"
#include "material/elastic_law.hpp"
#include "material/viscosity_registry.hpp"
#include "model/mesh_source.hpp"
#include "model/model.hpp"
#include "model/unknown_counts.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"
#include "petsc/session.hpp"
#include "run/advance.hpp"
#include "run/run.hpp"
#include "run/solver_setup.hpp"
#include "solver/linear.hpp"
#include "solver/petsc_method.hpp"
#include "time/method.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace pliant {
namespace {

/// Bytes that the run will need, over all ranks: exact for mesh and matrix, measured for the factors of MUMPS.
struct Memory {
  double matrix = 0.0;
  double factor = 0.0;
};

Memory predicted_memory(const Model& model, LinearKind kind) {
  const auto& pattern = model.pattern();
  const auto blocks = static_cast<double>(pattern.diagonal().nodes.size() + pattern.off_diagonal().nodes.size());
  Memory memory;
  memory.matrix = 9.0 * 12.0 * sum(model.layout().comm, blocks);  // value and column index
  const double unknowns = 3.0 * model.layout().num_global_nodes;
  // Nested dissection in three dimensions: the fill grows as n^(4/3) (George 1973). MUMPS with PORD was measured to
  // take 200 bytes times that on a cube of 24,000 unknowns, two thirds of it on slender bodies of 24,000 to 84,000.
  // GAMG's hierarchy takes about as much as the matrix.
  memory.factor = kind == LinearKind::cholesky ? 200.0 * std::pow(unknowns, 4.0 / 3.0) : 1.5 * memory.matrix;
  return memory;
}

std::string bytes(double n) {
  return n < 1e9 ? fmt::format("{:.0f} MB", std::ceil(n / 1e6)) : fmt::format("{:.1f} GB", n / 1e9);
}

/// The ranks that own ghosts of this one. Collective.
int num_neighbours(const NodeLayout& layout) {
  std::vector<PetscInt> first(static_cast<std::size_t>(num_ranks(layout.comm)));
  check_mpi(MPI_Allgather(&layout.first_global_node, 1, MPIU_INT, first.data(), 1, MPIU_INT, layout.comm));
  int count = 0;
  auto owner = first.begin();
  for (const PetscInt node : layout.ghost_global_nodes) {  // ascending
    const auto next = std::upper_bound(owner, first.end(), node);
    count += next != owner ? 1 : 0;
    owner = next;
  }
  return count;
}

using Lines = std::vector<std::string>;

void append(Lines& lines, std::vector<std::string> more) {
  std::ranges::move(more, std::back_inserter(lines));
}

/// The cost of updating the ghosts: numbers and messages.
void describe_communication(const NodeLayout& layout, Lines& lines) {
  const auto ghosts = static_cast<double>(layout.ghost_global_nodes.size()), neighbours = 1.0 * num_neighbours(layout);
  if (num_ranks(layout.comm) == 1) return;
  lines.push_back(
      fmt::format("  ghosts: {:.0f} to {:.0f} nodes per rank, {:.0f} in all; from {:.0f} to {:.0f} other ranks",
                  minimum(layout.comm, ghosts), maximum(layout.comm, ghosts), sum(layout.comm, ghosts),
                  minimum(layout.comm, neighbours), maximum(layout.comm, neighbours)));
}

/// Waves take time with inertia alone.
void describe_time_scales(const Model& model, const Config& config, Lines& lines) {
  const auto& [fastest, slowest] = model.wave_speeds();
  if (!(fastest > 0.0) || analysis_of(config) != Analysis::dynamic) return;
  const auto& b = model.mesh_report().bounds;
  const double length = std::max({b[3] - b[0], b[4] - b[1], b[5] - b[2]});
  const double across = length / slowest;
  lines.emplace_back("time scales");
  lines.push_back(fmt::format("  pressure wave across the smallest edge  {:.3g} s (an explicit code's step)",
                              model.mesh_report().min_edge / fastest));
  lines.push_back(fmt::format("  shear wave along the body               {:.3g} s", across));
  // Bending is slower than any wave; a twentieth of the shear transit resolves the lowest modes of compact bodies.
  constexpr double steps_per_wave = 10.0, steps_per_period = 20.0;
  lines.push_back(fmt::format("  suggested step                          {:.2g} s where such waves matter (a tenth)",
                              across / steps_per_wave));
  lines.push_back(
      fmt::format("  the input's step                        {:.3g} s: follows motions with periods from {:.2g} s on{}",
                  config.time.step, steps_per_period * config.time.step, config.time.adaptive ? ", at the start" : ""));
}

/// Throws InputError where a run could not start from there. Collective.
void describe_contact(const Model& model, const Config& config, Lines& lines) {
  if (model.contacts() == nullptr) return;
  const Handle<Vec> q = make_vector(model.layout()), v = make_vector(model.layout());
  if (analysis_of(config) != Analysis::static_equilibrium) {
    model.set_initial_state(config, q.get(), v.get());
  } else {
    model.check_contact_at_start(q.get());
  }
  update_ghosts(q.get());
  const ConstGhostedView at(q.get());
  append(lines, contact_table(model.contacts()->summary(model.instant_of_start(), at.span())));
}

/// What `pliant check` says of a model. Collective.
Lines description_of(Model& model, const Config& config) {
  const NodeLayout& layout = model.layout();
  Lines lines{config.mesh.file.value.empty() ? "mesh: none but that of rods and rigid bodies"
                                             : fmt::format("mesh {}", config.mesh.file.value)};
  std::string text = describe(model.mesh_report());
  if (!text.empty() && text.back() == '\n') text.pop_back();
  lines.push_back(text);
  append(lines, body_table(config, model));
  if (model.inertia() != nullptr) {
    lines.push_back(fmt::format("  mass {:.6g} kg", sum(layout.comm, model.inertia()->mass().total())));
  }
  append(lines, rod_table(config, model));
  append(lines, shell_table(config, model));
  append(lines, rigid_part_table(config, model));
  append(lines, mechanism_table(config, model));
  if (!model.cavities().empty()) lines.emplace_back("cavities");
  for (const auto& cavity : model.cavities()) {
    const auto is_other = cavity.enclosed && std::abs(*cavity.enclosed - cavity.volume) > 1e-6 * cavity.volume;
    lines.push_back(fmt::format("  {}: volume {:.6g} m^3{}", cavity.name, cavity.volume,
                                is_other ? fmt::format("; walls surround {:.6g} m^3", *cavity.enclosed) : ""));
  }
  describe_contact(model, config, lines);

  const LinearKind kind = linear_kind(config, model);
  const Memory memory = predicted_memory(model, kind);
  const UnknownCounts unknowns = count_unknowns(config, model);
  const auto mine = static_cast<double>(unknowns.mine);
  lines.emplace_back("unknowns");
  lines.push_back(fmt::format("  {} ({} prescribed), P{} elements; {:.0f} to {:.0f} per rank", unknowns.all,
                              unknowns.prescribed, layout.order, minimum(layout.comm, mine),
                              maximum(layout.comm, mine)));
  describe_communication(layout, lines);
  lines.push_back(fmt::format("  linear solver: {}", describe(kind, model.equation().symmetry())));
  lines.push_back(fmt::format("  predicted memory: matrix {}, {} about {}", bytes(memory.matrix),
                              kind == LinearKind::cholesky ? "factor" : "multigrid", bytes(memory.factor)));
  describe_time_scales(model, config, lines);
  return lines;
}

void check_model(const Config& config, Model& model, const Mesh* mesh, const std::string& page, Console& console) {
  const Lines lines = description_of(model, config);
  console.print(fmt::format("{}: the input is valid", config.file));
  for (const auto& line : lines) console.print(line);
  for (const auto& diagnostic : model.diagnostics()) console.report(diagnostic);
  if (mesh != nullptr) console.print(write_model_page(*mesh, config, model, lines, page));
}

}  // namespace

void plot_material_command(MPI_Comm comm, const std::string& law, const std::vector<std::string>& settings,
                           const std::array<double, 2>& stretches, const std::string& file) {
  const auto [lowest, highest] = stretches;
  if (!(lowest > 0.0 && lowest <= 1.0 && highest > 1.0)) {
    throw InputError({}, fmt::format("--stretch {:g} {:g}: the first must be above 0 and at most 1, the second above 1",
                                     lowest, highest));
  }
  const ElasticLawSpec spec = law_for_plot(law, settings);
  const std::string target = file.empty() ? law + ".svg" : file;
  write_svg(comm, target, stress_stretch_plot(spec, lowest, highest));
  if (rank(comm) == 0) fmt::print("{}: {}\n", target, describe(spec));
}

void convert_mesh_command(MPI_Comm comm, const Conversion& conversion, Console& console) {
  MeshReport report;
  on_root(comm, [&] {
    MeshSource source;
    source.file = conversion.from;
    source.scale = conversion.scale;
    source.commands = conversion.allows_commands ? Commands::allowed : Commands::refused;
    try {
      // The size is in metres, gmsh's in the unit of the geometry.
      if (!conversion.size.empty()) source.size = parse_quantity(conversion.size, "m") / conversion.scale;
    } catch (const UnitError& e) {
      throw InputError({}, "--size " + conversion.size + ": " + e.what());
    }
    report = convert_mesh(source, conversion.to);
  });
  console.print(fmt::format("{}: {} tetrahedra, {} vertices", conversion.to, report.num_cells, report.num_vertices));
  for (const auto& notice : report.notices) console.print("note: " + notice);
}

ExitCode run_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides, Console& console) {
  return run_with_output(comm, read_input_file(comm, file, overrides), console);
}

ExitCode check_command(MPI_Comm comm, const std::string& file, const std::vector<Override>& overrides,
                       const std::string& page, Console& console) {
  const Config config = read_input_file(comm, file, overrides);
  if (page.empty()) {
    Model model(comm, config);
    check_model(config, model, nullptr, page, console);
  } else {
    require_viewer();
    const Mesh mesh = read_mesh(comm, mesh_source(config));
    Model model(mesh, config);
    check_model(config, model, &mesh, page, console);
  }
  return ExitCode::done;
}

std::string methods_text() {
  constexpr std::size_t width = 100, indent = 4;
  constexpr const char* row = "{:<18}  {:<7} {:>6}  {:<12} {:>6}  {:<8} {:>8}  {}\n";
  std::string text =
      fmt::format(row, "method", "order", "solves", "stability", "R(inf)", "adaptive", "embedded", "viscous rate");
  for (const auto& m : methods()) {
    const bool loses_by_ramp = m.num_steps > 1 && m.order > 2;
    text += '\n' + fmt::format(row, m.name, loses_by_ramp ? fmt::format("{} (2)", m.order) : fmt::format("{}", m.order),
                               m.num_stages, to_string(m.stability), fmt::format("{:.3f}", m.R_infinity),
                               why_not_adaptive(m) ? "no" : "yes",
                               m.bt_embedded.empty() ? "-" : fmt::format("{}", m.embedded_order),
                               strain_rates()[static_cast<std::size_t>(strain_rate_for(m))].name);
    text += wrapped(m.summary, width, indent);
  }
  const auto legend = [&](const char* word, const char* meaning) {
    const std::string lines = wrapped(meaning, width, 14);
    text += fmt::format("{:<14}", word) + lines.substr(14);
  };
  text += '\n';
  legend("order",
         "of the error in displacement and velocity; in brackets after startup: ramp, without it after "
         "startup: dirk33");
  legend("solves", "nonlinear solves in a step");
  legend("R(inf)", "factor of a step on an infinitely fast decaying mode: 0 removes it, -1 and 1 keep it ringing");
  legend("adaptive",
         "whether the step can follow the error (time.adaptive); symplectic methods run at a constant step");
  legend("embedded",
         "order of the embedded formula that estimates the error, until (stiffly accurate methods) "
         "enough steps are known to estimate it better");
  legend("viscous rate",
         "the form of the strain rate that rate: auto takes: one with a potential to minimise, secant or "
         "reconstructed, where that keeps the order");
  text += "\nYour own coefficients: time: {method: {alpha: [...], beta: ..., A: [[...]], b: [...]}}.\n";
  text += "Integrators of PETSc, a second opinion: time: {method: {petsc: NAME}}, NAME one of\n";
  for (const auto& m : petsc_methods()) {
    text += wrapped(fmt::format("{} (order {}): {}", m.name, m.order, m.description), width, indent);
  }
  return text;
}

std::string materials_text() {
  std::string text;
  const auto list = [&](const char* title, std::span<const LawInfo> laws) {
    text += fmt::format("{}\n\n", title);
    for (const auto& law : laws) {
      text += fmt::format("{}\n  {}\n", law.name, law.formula);
      for (const auto& p : law.parameters) {
        text += fmt::format("  {:<16} [{}] {}: {}\n", p.name, p.unit, admissible(p), p.meaning);
      }
      text += fmt::format("  use: {}\n  source: {}\n\n", law.when_to_use, law.source);
    }
  };
  list("ELASTICITY (bodies[].elasticity)", elastic_laws());
  text +=
      "Where a law has two of these constants, any other two may be given; instead of a bulk_modulus alone a "
      "poissons_ratio, unless the law has fibres:\n";
  for (const auto& p : elastic_constants()) {
    text += fmt::format("  {:<16} [{}] {}: {}\n", p.name, p.unit, admissible(p), p.meaning);
  }
  text +=
      "U(J) by volumetric_energy: log (ln J)^2/2, quadratic (J - 1)^2/2, mixed (J^2 - 1 - 2 ln J)/4, the default.\n"
      "Stress over stretch as a picture: pliant materials plot LAW\n"
      "Measured materials: pliant materials --library\n\n";
  list("VISCOSITY (bodies[].viscosity)", viscosity_laws());
  text += "rate: the form of the strain rate of kelvin-voigt; auto takes what suits the method\n";
  for (const auto& rate : strain_rates()) {
    text += fmt::format("  {:<14} {}; {}\n", rate.name, rate.formula, rate.when_to_use);
  }
  return text;
}

}  // namespace pliant
