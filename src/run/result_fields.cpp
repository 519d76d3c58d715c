#include "run/result_fields.hpp"

#include "material/spectral.hpp"
#include "petsc/array_view.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace pliant {
namespace {

/// A field per cell.
struct CellResult {
  std::string_view name;
  const char* unit;
  void (*put)(const CellState&, double*);
};

/// xx yy zz xy yz xz
void put_symmetric(const Tensor3<double>& A, double* out) {
  std::ranges::copy(std::array{A(0, 0), A(1, 1), A(2, 2), A(0, 1), A(1, 2), A(0, 2)}, out);
}
Tensor3<double> symmetric(const std::array<double, 6>& a) {
  return {{a[0], a[3], a[5], a[3], a[1], a[4], a[5], a[4], a[2]}};
}

template <StressPart part>
void put_cauchy(const CellState& cell, double* out) {
  std::ranges::copy(cell.cauchy[static_cast<std::size_t>(part)], out);
}
template <StressPart part>
void put_energy(const CellState& cell, double* out) {
  *out = cell.energy_density[static_cast<std::size_t>(part)];
}

/// ln V = sum_i ln(l_i) r_i r_i^T, V^2 = F F^T.
void put_log_strain(const CellState& cell, double* out) {
  const auto stretches = principal_stretches(cell.H);
  Tensor3<double> strain{};
  for (int k = 0; k < 3; ++k) {
    const Vector3<double> r{stretches.r(0, k), stretches.r(1, k), stretches.r(2, k)};
    strain = strain + log1p(stretches.strain[static_cast<std::size_t>(k)]) * outer(r, r);
  }
  put_symmetric(strain, out);
}

constexpr std::array<CellResult, 16> cell_results{{
    {"cauchy_stress", "Pa", [](const CellState& cell, double* out) { std::ranges::copy(cell.total_cauchy(), out); }},
    {"elastic_cauchy_stress", "Pa", put_cauchy<StressPart::elastic>},
    {"viscous_cauchy_stress", "Pa", put_cauchy<StressPart::viscous>},
    {"active_cauchy_stress", "Pa", put_cauchy<StressPart::active>},
    {"von_mises_stress", "Pa", [](const CellState& cell, double* out) { *out = von_mises(cell.total_cauchy()); }},
    {"principal_stress", "Pa",
     [](const CellState& cell, double* out) {
       std::ranges::copy(eigen_decomposition(symmetric(cell.total_cauchy())).values, out);
     }},
    {"first_piola_kirchhoff_stress", "Pa",
     [](const CellState& cell, double* out) {
       std::ranges::copy(matmul(symmetric(cell.total_cauchy()), cofactor(add_to_diagonal(cell.H, 1.0))).a, out);
     }},
    {"displacement_gradient", "", [](const CellState& cell, double* out) { std::ranges::copy(cell.H.a, out); }},
    {"green_lagrange_strain", "",
     [](const CellState& cell, double* out) { put_symmetric(green_lagrange(cell.H), out); }},
    {"log_strain", "", put_log_strain},
    {"principal_stretches", "",
     [](const CellState& cell, double* out) { std::ranges::copy(principal_stretches(cell.H).l, out); }},
    {"volume_ratio", "", [](const CellState& cell, double* out) { *out = cell.volume_ratio; }},
    {"energy_density", "J/m^3",
     [](const CellState& cell, double* out) {
       *out = std::accumulate(cell.energy_density.begin(), cell.energy_density.end(), 0.0);
     }},
    {"elastic_energy_density", "J/m^3", put_energy<StressPart::elastic>},
    {"viscous_energy_density", "J/m^3", put_energy<StressPart::viscous>},
    {"softening", "", [](const CellState& cell, double* out) { *out = cell.softening; }},
}};

struct NodeResult {
  std::string_view name;
  const char* unit;
  Vec StepRecord::*values;
};

constexpr std::array<NodeResult, 3> node_results{{
    {"displacement", "m", &StepRecord::q},
    {"velocity", "m/s", &StepRecord::v},
    {"acceleration", "m/s^2", &StepRecord::a},
}};

/// A field per node, computed from its contact.
struct ContactResult {
  std::string_view name;
  const char* unit;
  void (*put)(const NodalContact&, double*);
};

constexpr std::array<ContactResult, 3> contact_results{{
    {"contact_pressure", "Pa", [](const NodalContact& c, double* out) { *out = c.pressure; }},
    {"contact_gap", "m", [](const NodalContact& c, double* out) { *out = c.gap; }},
    {"contact_slip", "m/s", [](const NodalContact& c, double* out) { std::ranges::copy(c.slip, out); }},
}};

/// A field of shells, per node in frames.
struct ShellResult {
  std::string_view name;
  const char* unit;
  void (*put)(const LayerState&, double*);
};

template <std::array<double, 6> LayerState::*tensor>
void put_layer_tensor(const LayerState& state, double* out) {
  std::ranges::copy(state.*tensor, out);
}
template <std::array<double, 6> LayerState::*tensor>
void put_principal(const LayerState& state, double* out) {
  std::ranges::copy(principal_values_in_layer(state.*tensor), out);
}

constexpr std::array<ShellResult, 5> shell_results{{
    {"membrane_force", "N/m", put_layer_tensor<&LayerState::force>},
    {"principal_membrane_force", "N/m", put_principal<&LayerState::force>},
    {"bending_moment", "N", put_layer_tensor<&LayerState::moment>},
    {"principal_bending_moment", "N", put_principal<&LayerState::moment>},
    {"principal_curvature", "1/m", put_principal<&LayerState::curvature>},
}};

/// A field of rods, per cell.
struct RodResult {
  std::string_view name;
  const char* unit;
  double RodResultants::*value;
};

constexpr std::array<RodResult, 3> rod_results{{
    {"rod_force", "N", &RodResultants::force},
    {"rod_bending_moment", "N m", &RodResultants::bending_moment},
    {"rod_torque", "N m", &RodResultants::torque},
}};

constexpr std::string_view error_name = "discretization_error";
constexpr const char* error_unit = "J/m^3";

OutputFieldInfo info_of_field(std::string_view name) {
  return *std::ranges::find(output_fields, name, &OutputFieldInfo::name);
}

/// Names of the fields of the frames, and of those of which the history has columns.
std::vector<std::string> names_in_use(const Config& config) {
  std::vector<std::string> names = config.output.fields;
  for (const FieldColumnConfig& column : config.output.history) {
    if (const auto of = field_component(column.of.value)) names.emplace_back(of->field.name);
  }
  return names;
}

using Numbers = std::array<double, sizeof(CellState) / sizeof(double)>;

}  // namespace

const char* unit_of_field(std::string_view name) {
  for (const auto& of : cell_results) {
    if (of.name == name) return of.unit;
  }
  for (const auto& of : node_results) {
    if (of.name == name) return of.unit;
  }
  for (const auto& of : contact_results) {
    if (of.name == name) return of.unit;
  }
  for (const auto& of : shell_results) {
    if (of.name == name) return of.unit;
  }
  for (const auto& of : rod_results) {
    if (of.name == name) return of.unit;
  }
  return name == error_name ? error_unit : "";
}

void put_shell_field(std::string_view name, const LayerState& state, double* out) {
  std::ranges::find(shell_results, name, &ShellResult::name)->put(state, out);
}

double rod_field(std::string_view name, const RodResultants& of) {
  return of.*(std::ranges::find(rod_results, name, &RodResult::name)->value);
}

std::array<double, 6> CellState::total_cauchy() const {
  std::array<double, 6> total{};
  for (const auto& part : cauchy) {
    for (std::size_t k = 0; k < total.size(); ++k) total[k] += part[k];
  }
  return total;
}

ResultFields::ResultFields(const Config& config, Model& model)
    : model_(model),
      shells_(config, model),
      shell_fields_(config, model),
      time_scale_(config.time.step > 0.0 ? config.time.step : 1.0),
      is_nodal_(config.output.is_nodal),
      work_(make_vector(model.layout())),
      triangles_(config.shells.size()) {
  const std::vector<std::string> names = names_in_use(config);
  if (asks_for_mesh_error(config)) mesh_error_.emplace(model);
  const auto is_of_cells = [&](const CellResult& of) { return std::ranges::find(names, of.name) != names.end(); };
  if (!is_nodal_ || std::ranges::none_of(cell_results, is_of_cells)) return;
  is_elastic_.assign(model.body_names().size(), 0);
  for (const int body : model.bodies_of_elastic()) is_elastic_[static_cast<std::size_t>(body)] = 1;
  // Stresses of linear elements are not accurate enough at centroids to be extrapolated from there. The gain was chosen
  // by the errors of stresses at the surface of a thick-walled cylinder on unstructured meshes.
  constexpr double trusted_gain = 2.0;
  recovery_.emplace(model.layout(), model.body_of_cell(),
                    PatchRecovery::Samples{{{0.25, 0.25, 0.25}}, model.layout().order - 1, trusted_gain});
}

void ResultFields::forget() {
  step_of_cells_.reset();
  step_of_nodes_.reset();
  step_of_parts_.reset();
  if (mesh_error_) mesh_error_->forget();
}

const std::vector<CellState>& ResultFields::cells(const StepRecord& record) {
  if (step_of_cells_ == record.step) return cells_;
  step_of_cells_ = record.step;
  cells_.assign(static_cast<std::size_t>(model_.layout().num_local_cells), {});
  model_.potential().accounts().visit_stresses(record.instant(model_), record.q, record.v, record.z,
                                               [&](StressPart part, PetscInt cell, const CellStress& stress) {
                                                 CellState& state = cells_[static_cast<std::size_t>(cell)];
                                                 const auto p = static_cast<std::size_t>(part);
                                                 for (std::size_t k = 0; k < stress.cauchy.size(); ++k)
                                                   state.cauchy[p][k] += stress.cauchy[k];
                                                 state.energy_density[p] += stress.energy_density;
                                                 state.softening += stress.softening;
                                                 state.H = stress.H;
                                                 if (part == StressPart::elastic)
                                                   state.volume_ratio = stress.volume_ratio;
                                               });
  return cells_;
}

/// Tensors are recovered, and what is derived from them follows. Numbers that cannot be negative stay so.
const std::vector<CellState>& ResultFields::nodes(const StepRecord& record) {
  if (step_of_nodes_ == record.step) return nodes_;
  step_of_nodes_ = record.step;
  const std::vector<CellState>& of_cells = cells(record);
  std::vector<double> numbers;
  for (const CellState& cell : of_cells) {
    const auto more = std::bit_cast<Numbers>(cell);
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
  const auto at_nodes = recovery_->at_nodes(numbers, std::tuple_size_v<Numbers>, is_elastic_);
  nodes_.assign(static_cast<std::size_t>(model_.layout().num_local_nodes), {});
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    if (at_nodes.has_value[n] == 0) continue;
    Numbers of_node;
    std::copy_n(&at_nodes.values[of_node.size() * n], of_node.size(), of_node.begin());
    nodes_[n] = std::bit_cast<CellState>(of_node);
    for (double& density : nodes_[n].energy_density) density = std::max(density, 0.0);
    nodes_[n].softening = std::clamp(nodes_[n].softening, 0.0, 1.0);
  }
  return nodes_;
}

std::vector<double> ResultFields::of_nodes(Vec values) {
  if (values == nullptr) return std::vector<double>(3 * static_cast<std::size_t>(model_.layout().num_local_nodes), 0.0);
  check(VecCopy(values, work_.get()));
  update_ghosts(work_.get());
  const ConstGhostedView view(work_.get());
  return {view.span().begin(), view.span().end()};
}

void ResultFields::with_ghosts(std::vector<double>& owned, std::size_t width) {
  const NodeLayout& layout = model_.layout();
  owned.resize(width * static_cast<std::size_t>(layout.num_local_nodes));
  for (std::size_t first = 0; first < width; first += 3) {  // as many as the vector has for each node
    const std::size_t count = std::min<std::size_t>(3, width - first);
    {
      const ArrayView view(work_.get());
      for (PetscInt n = 0; n < layout.num_owned_nodes; ++n) {
        for (std::size_t c = 0; c < count; ++c) view[3 * n + static_cast<PetscInt>(c)] = owned[width * n + first + c];
      }
    }
    update_ghosts(work_.get());
    const ConstGhostedView view(work_.get());
    for (PetscInt n = layout.num_owned_nodes; n < layout.num_local_nodes; ++n) {
      for (std::size_t c = 0; c < count; ++c) owned[width * n + first + c] = view.span()[3 * n + c];
    }
  }
}

void ResultFields::add_contact_fields(const StepRecord& record, std::span<const std::string> names,
                                      std::vector<FieldValues>& fields) {
  std::optional<std::vector<NodalContact>> nodes;
  for (const ContactResult& of : contact_results) {
    if (std::ranges::find(names, of.name) == names.end()) continue;
    if (!nodes) {
      const ConstArrayView u(record.q), velocity(record.v);
      nodes = model_.contacts()->at_nodes(record.instant(model_), time_scale_, u.span(), velocity.span());
    }
    FieldValues field{info_of_field(of.name), of.unit, FieldLocation::node, {}};
    field.values.resize(field.width() * nodes->size());
    for (std::size_t a = 0; a < nodes->size(); ++a) of.put((*nodes)[a], &field.values[field.width() * a]);
    with_ghosts(field.values, field.width());
    fields.push_back(std::move(field));
  }
}

const std::vector<LayerTriangle>& ResultFields::triangles_of_shell(std::size_t shell, const StepRecord& record) {
  forget_parts_before(record.step);
  if (!triangles_[shell]) triangles_[shell] = shell_fields_.of_triangles(shell, record);
  return *triangles_[shell];
}

const RodState& ResultFields::rods(const StepRecord& record) {
  forget_parts_before(record.step);
  if (!rods_) rods_ = state_of_rods(model_, record);
  return *rods_;
}

void ResultFields::forget_parts_before(std::int64_t step) {
  if (step_of_parts_ == step) return;
  step_of_parts_ = step;
  for (auto& triangles : triangles_) triangles.reset();
  rods_.reset();
}

void ResultFields::add_shell_fields(const StepRecord& record, std::span<const std::string> names,
                                    std::vector<FieldValues>& fields) {
  std::optional<std::vector<LayerState>> nodes;
  for (const ShellResult& of : shell_results) {
    if (std::ranges::find(names, of.name) == names.end()) continue;
    if (!nodes) {
      nodes = shell_fields_.at_nodes(
          [&](std::size_t s) -> const std::vector<LayerTriangle>& { return triangles_of_shell(s, record); });
    }
    FieldValues field{info_of_field(of.name), of.unit, FieldLocation::node, {}};
    field.values.resize(field.width() * nodes->size());
    for (std::size_t n = 0; n < nodes->size(); ++n) of.put((*nodes)[n], &field.values[field.width() * n]);
    with_ghosts(field.values, field.width());
    shells_.average(field.values, field.width());
    fields.push_back(std::move(field));
  }
}

void ResultFields::add_rod_fields(const StepRecord& record, std::span<const std::string> names,
                                  std::vector<FieldValues>& fields) {
  for (const RodResult& of : rod_results) {
    if (std::ranges::find(names, of.name) == names.end()) continue;
    FieldValues field{info_of_field(of.name), of.unit, FieldLocation::cell, {}};
    const RodState& state = rods(record);
    if (!model_.rods().term) field.values.assign(static_cast<std::size_t>(model_.layout().num_local_cells), 0.0);
    for (const std::ptrdiff_t segment : model_.rods().segment_of_cell()) {
      field.values.push_back(segment < 0 ? 0.0 : state.middles[static_cast<std::size_t>(segment)].*of.value);
    }
    fields.push_back(std::move(field));
  }
}

std::vector<FieldValues> ResultFields::at(const StepRecord& record, std::span<const std::string> names) {
  std::vector<FieldValues> fields;
  const auto is_wanted = [&](std::string_view name) { return std::ranges::find(names, name) != names.end(); };
  for (const NodeResult& of : node_results) {
    if (is_wanted(of.name)) {
      fields.push_back({info_of_field(of.name), of.unit, FieldLocation::node, of_nodes(record.*of.values)});
      if (of.values == &StepRecord::q) {
        shells_.displace(fields.back().values);
      } else {
        shells_.average(fields.back().values);
      }
    }
  }
  if (model_.contacts() != nullptr) add_contact_fields(record, names, fields);
  if (!model_.shells().shells.empty()) add_shell_fields(record, names, fields);
  if (!model_.rods().rods.empty()) add_rod_fields(record, names, fields);
  for (const CellResult& of : cell_results) {
    if (!is_wanted(of.name)) continue;
    const std::vector<CellState>& states = is_nodal_ ? nodes(record) : cells(record);
    FieldValues field{info_of_field(of.name), of.unit, is_nodal_ ? FieldLocation::node : FieldLocation::cell, {}};
    field.values.resize(field.width() * states.size());
    for (std::size_t k = 0; k < states.size(); ++k) of.put(states[k], &field.values[field.width() * k]);
    fields.push_back(std::move(field));
  }
  if (is_wanted(error_name)) {
    (void)mesh_error_->at(record);
    fields.push_back({info_of_field(error_name), error_unit, FieldLocation::cell, mesh_error_->densities()});
  }
  return fields;
}

}  // namespace pliant
