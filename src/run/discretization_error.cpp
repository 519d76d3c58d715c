#include "run/discretization_error.hpp"

#include "fem/cell_integration.hpp"
#include "fem/quadrature.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::size_t num_entries = 9;
constexpr std::string_view error_field = "discretization_error";
/// Strains below this are rounding errors of displacements [1].
constexpr double negligible_strain = 1e-10;

/// Where the gradients of elements of the order are most accurate: the centroid of linear ones, four points of
/// quadratic ones.
PatchRecovery::Samples best_points(int order) {
  return {simplex_rule<3>(order == 1 ? 1 : 2).points, order};
}

/// Bodies with an elastic term; -1 elsewhere.
std::vector<int> elastic_body_of_cell(const Model& model) {
  std::vector<int> result = model.body_of_cell();
  for (int& body : result) {
    if (std::ranges::find(model.bodies_of_elastic(), body) == model.bodies_of_elastic().end()) body = -1;
  }
  return result;
}

double energy_of(const Model& model, const Instant& at, std::span<const double> u) {
  double energy = 0.0;
  for (const auto& term : model.elastic()) energy += term->energy_at(at, u, {});
  return energy;
}

}  // namespace

DiscretizationError::DiscretizationError(Model& model)
    : model_(model), recovery_(model.layout(), elastic_body_of_cell(model), best_points(model.layout().order)) {
  find_groups();
  const NodeLayout& layout = model.layout();
  for (PetscInt cell = 0; cell < layout.num_owned_cells; ++cell) {
    const double modulus = model.shear_moduli()[static_cast<std::size_t>(model.body_of_cell()[cell])];
    for_each_point_of_cell(layout, cell, [&](const IntegrationPoint& point) {
      negligible_ += point.weight * modulus * negligible_strain * negligible_strain;
    });
  }
  negligible_ = sum(layout.comm, negligible_);
}

/// Greedily: a body joins the first group with whose bodies it shares no node.
void DiscretizationError::find_groups() {
  const NodeLayout& layout = model_.layout();
  const std::size_t count = model_.body_names().size();
  std::vector<std::pair<PetscInt, int>> bodies_at;  // nodes, each with its bodies
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    for (const PetscInt n : layout.nodes_of_cell(cell)) bodies_at.emplace_back(n, model_.body_of_cell()[cell]);
  }
  std::ranges::sort(bodies_at);
  bodies_at.erase(std::ranges::unique(bodies_at).begin(), bodies_at.end());
  std::vector<double> shares(count * count, 0.0);
  for (std::size_t i = 0; i < bodies_at.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies_at.size() && bodies_at[j].first == bodies_at[i].first; ++j) {
      const int a = bodies_at[i].second, b = bodies_at[j].second;
      shares[count * a + b] = shares[count * b + a] = 1.0;
    }
  }
  sum_in_place(layout.comm, shares);
  for (const int body : model_.bodies_of_elastic()) {
    const auto can_join = [&](const std::vector<char>& group) {
      for (std::size_t b = 0; b < count; ++b) {
        if (group[b] != 0 && shares[count * body + b] > 0.0) return false;
      }
      return true;
    };
    auto group = std::ranges::find_if(groups_, can_join);
    if (group == groups_.end()) group = groups_.insert(groups_.end(), std::vector<char>(count, 0));
    (*group)[body] = 1;
  }
}

void DiscretizationError::recover(const Instant& at, std::span<const double> u) {
  const NodeLayout& layout = model_.layout();
  const auto points = best_points(layout.order).points;
  std::vector<double> gradients;
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    for (const auto& xi : points) {
      const Tensor3<double> H = gradient_in_cell(layout, cell, xi, u);
      gradients.insert(gradients.end(), H.a.begin(), H.a.end());
    }
  }
  densities_.assign(static_cast<std::size_t>(layout.num_local_cells), 0.0);
  double energy = 0.0;
  for (const auto& group : groups_) {
    const std::vector<double> at_nodes = recovery_.at_nodes(gradients, num_entries, group).values;
    for (std::size_t k = 0; k < model_.elastic().size(); ++k) {
      if (group[model_.bodies_of_elastic()[k]] == 0) continue;
      const RecoveredState state{at, layout.coordinates, u, at_nodes};
      model_.elastic()[k]->recovery_errors(state, [&](PetscInt cell, const RecoveryError& error) {
        densities_[cell] = error.energy / error.volume;
        if (cell < layout.num_owned_cells) energy += error.energy;
      });
    }
  }
  error_.energy = energy;
}

const MeshError& DiscretizationError::at(const StepRecord& record) {
  if (step_ == record.step) return error_;
  step_ = record.step;
  error_ = {};
  const NodeLayout& layout = model_.layout();
  const ConstGhostedView u(record.q);
  const Instant now = record.instant(model_);
  recover(now, u.span());
  error_.energy = sum(layout.comm, error_.energy);
  error_.elastic = sum(layout.comm, energy_of(model_, now, u.span()));
  const double all = error_.energy + error_.elastic;
  error_.share = all > negligible_ ? error_.energy / all : 0.0;
  struct {
    double density;
    int rank;
  } mine{-1.0, 0}, largest{};
  check_mpi(MPI_Comm_rank(layout.comm, &mine.rank));
  const auto end = densities_.begin() + layout.num_owned_cells;
  const auto here = std::max_element(densities_.begin(), end);
  if (here != end) mine.density = *here;
  check_mpi(MPI_Allreduce(&mine, &largest, 1, MPI_DOUBLE_INT, MPI_MAXLOC, layout.comm));
  if (mine.rank == largest.rank && here != end) {
    error_.place = position_in_cell(layout, static_cast<PetscInt>(here - densities_.begin()), {0.25, 0.25, 0.25});
  }
  check_mpi(MPI_Bcast(error_.place.data(), 3, MPI_DOUBLE, largest.rank, layout.comm));
  return error_;
}

void MeshErrorWatch::look(const MeshError& error, double time) {
  if (!(error.elastic + error.energy > worst_.elastic + worst_.energy)) return;
  worst_ = error;
  time_ = time;
}

bool asks_for_mesh_error(const Config& config) {
  const auto is_it = [](const FieldColumnConfig& column) { return column.of.value == error_field; };
  return std::ranges::find(config.output.fields, error_field) != config.output.fields.end() ||
         std::ranges::any_of(config.output.history, is_it);
}

std::string in_words(const MeshErrorWatch& watch, std::string_view when) {
  const auto& [x, y, z] = watch.worst().place;
  const double percent = 100.0 * watch.worst().share;
  return fmt::format(
      "discretization error: {} % of the elastic energy, when that was largest ({}); most of it per volume around "
      "({:.4g}, {:.4g}, {:.4g})",
      percent < 10.0 ? fmt::format("{:.2g}", percent) : fmt::format("{:.0f}", percent), when, x, y, z);
}

std::optional<Diagnostic> warning_about(const MeshErrorWatch& watch, const Config& config) {
  const MeshError& error = watch.worst();
  if (!(error.share > MeshErrorWatch::tolerance)) return std::nullopt;
  const auto& [x, y, z] = error.place;
  const char* remedy = config.element == ElementOrder::p1 ? "choose quadratic elements (`element: P2`) or a finer mesh"
                                                          : "choose a finer mesh";
  return Diagnostic{
      Severity::warning, config.mesh.file.where,
      fmt::format("the mesh is too coarse: its discretization error is about {:.0f} % of the elastic energy, so that "
                  "displacements or forces are off by about as much; {}, first around ({:.4g}, {:.4g}, {:.4g}); the "
                  "field discretization_error shows where else",
                  100.0 * error.share, remedy, x, y, z)};
}

std::optional<Diagnostic> note_about_linear_elements(Model& model, const Config& config, const StepRecord& record,
                                                     const Energies& energies) {
  // A larger share of the energy than this means that a body is far too stiff, by half or more.
  constexpr double far_too_large = 0.3;
  constexpr double little = 0.1;  // a body that came to rest under its weight keeps a third or more
  if (config.element != ElementOrder::p1 || model.elastic().empty()) return std::nullopt;
  const double lost = energies.dissipated + std::max(energies.numerical_dissipation, 0.0);
  if (energies.elastic < little * (energies.elastic + energies.kinetic + lost)) return std::nullopt;
  const MeshError error = DiscretizationError(model).at(record);
  if (!(error.share > far_too_large)) return std::nullopt;
  const auto& [x, y, z] = error.place;
  return Diagnostic{
      Severity::note, config.mesh.file.where,
      fmt::format("linear elements are too coarse here: about {:.0f} % of the elastic energy at the end is "
                  "discretization error, so that the bodies are far too stiff, mostly in bending with "
                  "fewer than four elements across; choose quadratic elements (`element: P2`), or a finer "
                  "mesh, first around ({:.4g}, {:.4g}, {:.4g}); `output.fields: [displacement, "
                  "discretization_error]` shows where else and how it changes",
                  100.0 * error.share, x, y, z)};
}

void MeshErrorWatch::keep(Archive& archive) {
  const Archive::Section section(archive, "mesh_error");
  archive.number("energy", worst_.energy);
  archive.number("share", worst_.share);
  archive.number("elastic", worst_.elastic);
  archive.numbers("place", worst_.place);
  archive.number("time", time_);
}

}  // namespace pliant
