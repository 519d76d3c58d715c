#include "run/field_columns.hpp"

#include "fem/cell_integration.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

constexpr std::string_view gradient_name = "displacement_gradient";
constexpr std::string_view displacement_name = "displacement";
constexpr std::string_view curvature_name = "principal_curvature";

std::vector<double> sizes_of(const NodeLayout& layout, const FieldRegion& region) {
  std::vector<double> sizes;
  for (const PetscInt cell : region.cells) {
    double& size = sizes.emplace_back(0.0);
    for_each_point_of_cell(layout, cell, [&](const IntegrationPoint& point) { size += point.weight; });
  }
  for (std::size_t f = 0; f < region.facets_cells.size(); ++f) {
    double& size = sizes.emplace_back(0.0);
    for_each_point_of_facet(layout, region.nodes_of_facet(f),
                            [&](const IntegrationPoint& point) { size += point.weight; });
  }
  return sizes;
}

/// Counts all components; those outside the diagonal of a symmetric tensor (xx, yy, zz, then three others) stand for
/// two.
double norm_of(const double* values, int count) {
  constexpr int symmetric = 6, diagonal = 3;
  double sum = 0.0;
  for (int i = 0; i < count; ++i) sum += (count == symmetric && i >= diagonal ? 2.0 : 1.0) * values[i] * values[i];
  return std::sqrt(sum);
}

}  // namespace

FieldColumns::FieldColumns(const Config& config, const Model& model, ResultFields& fields)
    : model_(model), layout_(model.layout()), fields_(fields) {
  const auto need = [&](std::string_view name) {
    if (std::ranges::find(names_, name) == names_.end()) names_.emplace_back(name);
  };
  for (std::size_t k = 0; k < config.output.history.size(); ++k) {
    const FieldColumnConfig& column = config.output.history[k];
    const FieldRegion& region = model.field_regions()[k];
    columns_.push_back(
        {*field_component(column.of.value), column.take.value_or(Take::mean), &region, sizes_of(layout_, region)});
    if (column.at) {
      const auto probe = std::ranges::find(config.probes, column.at->value, &ProbeConfig::name);
      columns_.back().probe = &model.probes()[static_cast<std::size_t>(probe - config.probes.begin())];
    }
    const FieldOwner owner = columns_.back().of.field.owner;
    if (owner != FieldOwner::shells && owner != FieldOwner::rods) need(columns_.back().of.field.name);
    if (column.of.value == gradient_name && column.take == Take::norm) need(displacement_name);
  }
}

double FieldColumns::Column::number(const double* values) const {
  if (of.component) return values[*of.component];
  const int count = num_components(of.field.shape);
  return count == 1 ? *values : norm_of(values, count);
}

void FieldColumns::add(const Column& column, double weight, const double* values, Partial& sum) {
  const double number = column.number(values);
  sum.integral += weight * (column.take == Take::norm ? number * number : number);
  sum.size += weight;
}

void FieldColumns::compare(const Column& column, const double* values, Partial& sum) {
  const double number = column.number(values);
  sum.largest = std::max(sum.largest, column.take == Take::min ? -number : number);
}

void FieldColumns::take_at_probe(const Column& column, const FieldValues& field, Partial& sum) {
  const ProbeLocation& probe = *column.probe;
  if (probe.nodes.empty()) return;  // another rank's
  const std::size_t width = field.width();
  if (field.location == FieldLocation::cell) {
    add(column, 1.0, &field.values[width * static_cast<std::size_t>(probe.cell)], sum);
    return;
  }
  std::vector<double> there(width);
  for (std::size_t a = 0; a < probe.nodes.size(); ++a) {
    const double* value = &field.values[width * static_cast<std::size_t>(probe.nodes[a])];
    for (std::size_t c = 0; c < width; ++c) there[c] += probe.weights[a] * value[c];
  }
  add(column, 1.0, there.data(), sum);
}

void FieldColumns::take_from_cells(const Column& column, const FieldValues& field, Partial& sum) const {
  const FieldRegion& region = *column.region;
  const auto values = [&](PetscInt cell) { return &field.values[field.width() * static_cast<std::size_t>(cell)]; };
  for (std::size_t k = 0; k < region.cells.size(); ++k) {
    compare(column, values(region.cells[k]), sum);
    add(column, column.sizes[k], values(region.cells[k]), sum);
  }
  for (std::size_t f = 0; f < region.facets_cells.size(); ++f) {
    const auto& sides = region.facets_cells[f];
    const double share = sides[1] < 0 ? 1.0 : 0.5;
    for (const PetscInt cell : sides) {
      if (cell < 0) continue;
      compare(column, values(cell), sum);
      add(column, share * column.sizes[f], values(cell), sum);
    }
  }
}

void FieldColumns::take_from_nodes(const Column& column, const FieldValues& field, Partial& sum) const {
  const std::size_t width = field.width();
  std::vector<double> there(width);
  const auto visit = [&](std::span<const PetscInt> nodes, const auto& for_each_point) {
    for (const PetscInt n : nodes) compare(column, &field.values[width * static_cast<std::size_t>(n)], sum);
    if (column.take == Take::max || column.take == Take::min) return;
    for_each_point([&](const IntegrationPoint& point) {
      std::ranges::fill(there, 0.0);
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        const double* value = &field.values[width * static_cast<std::size_t>(nodes[a])];
        for (std::size_t c = 0; c < width; ++c) there[c] += point.shape[a] * value[c];
      }
      add(column, point.weight, there.data(), sum);
    });
  };
  for (const PetscInt cell : column.region->cells) {
    visit(layout_.nodes_of_cell(cell), [&](const auto& at) { for_each_point_of_cell(layout_, cell, at); });
  }
  for (std::size_t f = 0; f < column.region->facets_cells.size(); ++f) {
    const auto nodes = column.region->nodes_of_facet(f);
    visit(nodes, [&](const auto& at) { for_each_point_of_facet(layout_, nodes, at); });
  }
}

void FieldColumns::take_squares_of_gradient(const Column& column, std::span<const double> u, Partial& sum) const {
  for (const PetscInt cell : column.region->cells) {
    for_each_point_of_cell(layout_, cell, [&](const IntegrationPoint& point) {
      add(column, point.weight, gradient_in_cell(layout_, cell, point.xi, u).a.data(), sum);
    });
  }
}

void FieldColumns::take_from_shells(const Column& column, const StepRecord& record, Partial& sum) const {
  const std::string_view name = column.of.field.name;
  std::array<double, 6> values{};
  for (const std::size_t shell : column.region->parts) {
    for (const LayerTriangle& triangle : fields_.triangles_of_shell(shell, record)) {
      if (!triangle.is_counted || (name == curvature_name && !triangle.has_curvature)) continue;
      put_shell_field(name, triangle.state, values.data());
      compare(column, values.data(), sum);
      add(column, triangle.area, values.data(), sum);
    }
  }
}

/// Every rank knows all of them: the first takes them.
void FieldColumns::take_from_rods(const Column& column, const StepRecord& record, Partial& sum) const {
  const RodState& state = fields_.rods(record);
  int rank = 0;
  check_mpi(MPI_Comm_rank(layout_.comm, &rank));
  if (rank != 0) return;
  for (const std::size_t number : column.region->parts) {
    const ModelRod& rod = model_.rods().rods[number];
    for (std::size_t s = rod.first_segment; s < rod.first_segment + rod.num_segments(); ++s) {
      const double value = rod_field(column.of.field.name, state.middles[s]);
      add(column, model_.rods().lengths[s], &value, sum);
      for (const RodResultants& end : state.ends[s]) {
        const double at_end = rod_field(column.of.field.name, end);
        compare(column, &at_end, sum);
      }
    }
  }
}

std::vector<double> FieldColumns::values(const StepRecord& record) {
  if (columns_.empty()) return {};
  const std::vector<FieldValues> fields = fields_.at(record, names_);
  const auto field_of = [&](std::string_view name) -> const FieldValues& {
    return *std::ranges::find_if(fields, [&](const FieldValues& field) { return field.info.name == name; });
  };
  std::vector<double> sums, largest;
  for (const Column& column : columns_) {
    Partial sum;
    if (column.of.field.owner == FieldOwner::shells || column.of.field.owner == FieldOwner::rods) {
      column.of.field.owner == FieldOwner::shells ? take_from_shells(column, record, sum)
                                                  : take_from_rods(column, record, sum);
      sums.insert(sums.end(), {sum.integral, sum.size});
      largest.push_back(sum.largest);
      continue;
    }
    const FieldValues& field = field_of(column.of.field.name);
    const bool is_exact = column.of.field.name == gradient_name && !column.of.component && column.take == Take::norm &&
                          field.location == FieldLocation::cell && column.region->facets_cells.empty();
    if (column.probe != nullptr) {
      take_at_probe(column, field, sum);
    } else if (is_exact) {
      take_squares_of_gradient(column, field_of(displacement_name).values, sum);
    } else if (field.location == FieldLocation::cell) {
      take_from_cells(column, field, sum);
    } else {
      take_from_nodes(column, field, sum);
    }
    sums.insert(sums.end(), {sum.integral, sum.size});
    largest.push_back(sum.largest);
  }
  sum_in_place(layout_.comm, sums);
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, layout_.comm));
  std::vector<double> values;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const double integral = sums[2 * k], size = sums[2 * k + 1];
    switch (columns_[k].take) {
      case Take::max:
        values.push_back(largest[k]);
        break;
      case Take::min:
        values.push_back(-largest[k]);
        break;
      case Take::mean:
        values.push_back(integral / size);
        break;
      case Take::integral:
        values.push_back(integral);
        break;
      case Take::norm:
        values.push_back(std::sqrt(integral));
        break;
    }
  }
  return values;
}

}  // namespace pliant
