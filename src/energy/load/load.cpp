#include "energy/load/load.hpp"

#include "base/compensated_sum.hpp"
#include "base/tensor.hpp"
#include "fem/element.hpp"
#include "fem/quadrature.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Place = std::array<double, 3>;

/// Volume, area or length per reference measure, from the columns dX/dxi_k.
template <std::size_t Dim>
double measure(const std::array<Place, Dim>& columns) {
  if constexpr (Dim == 3) {
    const Place n = cross(columns[0], columns[1]);
    return n[0] * columns[2][0] + n[1] * columns[2][1] + n[2] * columns[2][2];
  } else if constexpr (Dim == 2) {
    return norm(cross(columns[0], columns[1]));
  } else {
    return norm(columns[0]);
  }
}

/// Adds the samples of items of one shape.
template <int Dim, int Order>
class Sampler {
  using Element = Simplex<Dim, Order>;

 public:
  /// Exact for a uniform load on straight items; curved mappings and loads that vary in space raise the degree.
  Sampler(const NodeLayout& layout, Variation variation)
      : layout_(layout),
        rule_(simplex_rule<Dim>(Order + Dim * (Order - 1) + (variation == Variation::in_space ? 4 : 0))) {
    samples_.nodes_per_item = Element::num_nodes;
    samples_.points_per_item = rule_.size();
    for (const auto& xi : rule_.points) {
      const auto N = Element::values(xi);
      samples_.shapes.emplace_back(N.begin(), N.end());
    }
  }

  void add(std::span<const PetscInt> nodes, double factor) {
    samples_.nodes.insert(samples_.nodes.end(), nodes.begin(), nodes.end());
    for (int q = 0; q < rule_.size(); ++q) {
      const auto dN = Element::gradients(rule_.points[q]);
      Place x{};
      std::array<Place, Dim> columns{};
      for (int a = 0; a < Element::num_nodes; ++a) {
        const Place X = layout_.position(nodes[a]);
        for (int i = 0; i < 3; ++i) {
          x[i] += samples_.shapes[q][a] * X[i];
          for (int k = 0; k < Dim; ++k) columns[k][i] += X[i] * dN[a][k];
        }
      }
      samples_.points.push_back(x);
      samples_.weights.push_back(factor * rule_.weights[q] * measure(columns));
    }
  }

  LoadSamples take() {
    samples_.weights.shrink_to_fit();
    return std::move(samples_);
  }

 private:
  const NodeLayout& layout_;
  QuadratureRule<Dim> rule_;
  LoadSamples samples_;
};

template <int Order>
LoadSamples cell_samples_of(const NodeLayout& layout, const std::vector<double>& factor_of_cell, Variation variation) {
  Sampler<3, Order> sampler(layout, variation);
  std::vector<PetscInt> cells;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (factor_of_cell[c] == 0.0) continue;
    sampler.add(layout.nodes_of_cell(c), factor_of_cell[c]);
    cells.push_back(c);
  }
  LoadSamples samples = sampler.take();
  cells.shrink_to_fit();
  samples.cells = std::move(cells);
  return samples;
}

/// The position derivatives dX/dxi_k of a cell.
template <int Order>
std::array<Place, 3> mapping_columns(const NodeLayout& layout, std::span<const PetscInt> nodes, const Place& xi) {
  const auto dN = Tet<Order>::gradients(xi);
  std::array<Place, 3> columns{};
  for (std::size_t a = 0; a < dN.size(); ++a) {
    const Place X = layout.position(nodes[a]);
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) columns[k][i] += X[i] * dN[a][k];
    }
  }
  return columns;
}

template <int Order>
LoadSamples lumped_samples_of(const NodeLayout& layout, const std::vector<double>& factor_of_cell) {
  constexpr int n = Tet<Order>::num_nodes;
  const auto straight = simplex_rule<3>(2 * Order), curved = simplex_rule<3>(5 * Order - 3);
  LoadSamples samples;
  samples.nodes_per_item = samples.points_per_item = n;
  for (int a = 0; a < n; ++a) {
    samples.shapes.emplace_back(n, 0.0);
    samples.shapes.back()[a] = 1.0;
  }
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    if (factor_of_cell[c] == 0.0) continue;
    const auto nodes = layout.nodes_of_cell(c);
    const auto& rule = layout.cell_is_affine[c] ? straight : curved;
    std::array<double, n> squares{};  // int N_a^2
    double volume = 0.0, sum_of_squares = 0.0;
    for (int q = 0; q < rule.size(); ++q) {
      const auto N = Tet<Order>::values(rule.points[q]);
      const double weight = rule.weights[q] * measure(mapping_columns<Order>(layout, nodes, rule.points[q]));
      volume += weight;
      for (int a = 0; a < n; ++a) {
        squares[a] += weight * N[a] * N[a];
        sum_of_squares += weight * N[a] * N[a];
      }
    }
    samples.nodes.insert(samples.nodes.end(), nodes.begin(), nodes.end());
    samples.cells.push_back(c);
    for (int a = 0; a < n; ++a) {
      samples.points.push_back(layout.position(nodes[a]));
      samples.weights.push_back(factor_of_cell[c] * volume * squares[a] / sum_of_squares);
    }
  }
  return samples;
}

/// Items given by their nodes.
template <int Dim, int Order>
LoadSamples item_samples_of(const NodeLayout& layout, std::span<const PetscInt> nodes, Variation variation) {
  constexpr std::size_t n = Simplex<Dim, Order>::num_nodes;
  Sampler<Dim, Order> sampler(layout, variation);
  for (std::size_t first = 0; first < nodes.size(); first += n) sampler.add(nodes.subspan(first, n), 1.0);
  return sampler.take();
}

}  // namespace

LoadSamples cell_samples(const NodeLayout& layout, const std::vector<double>& factor_of_cell, Variation variation) {
  return layout.order == 1 ? cell_samples_of<1>(layout, factor_of_cell, variation)
                           : cell_samples_of<2>(layout, factor_of_cell, variation);
}

LoadSamples lumped_cell_samples(const NodeLayout& layout, const std::vector<double>& factor_of_cell) {
  return layout.order == 1 ? lumped_samples_of<1>(layout, factor_of_cell)
                           : lumped_samples_of<2>(layout, factor_of_cell);
}

LoadSamples facet_samples(const NodeLayout& layout, const FacetList& facets, Variation variation) {
  return layout.order == 1 ? item_samples_of<2, 1>(layout, facets.nodes, variation)
                           : item_samples_of<2, 2>(layout, facets.nodes, variation);
}

LoadSamples edge_samples(const NodeLayout& layout, const EdgeList& edges, Variation variation) {
  return layout.order == 1 ? item_samples_of<1, 1>(layout, edges.nodes, variation)
                           : item_samples_of<1, 2>(layout, edges.nodes, variation);
}

LoadSamples node_samples(const NodeLayout& layout, const std::vector<PetscInt>& nodes) {
  LoadSamples samples{1, 1, nodes, {}, {{1.0}}, {}, std::vector<double>(nodes.size(), 1.0)};
  for (const PetscInt node : nodes) samples.points.push_back(layout.position(node));
  return samples;
}

LoadSamples with_total_weight_one(const NodeLayout& layout, LoadSamples samples, const std::vector<char>& is_owned) {
  double mine = 0.0;
  for (std::size_t p = 0; p < samples.weights.size(); ++p) {
    if (is_owned[p / samples.points_per_item]) mine += samples.weights[p];
  }
  const double total = sum(layout.comm, mine);
  for (double& weight : samples.weights) weight /= total;
  return samples;
}

Variation variation_of(const std::array<Expression, 3>& value) {
  const auto varies = [](const Expression& e) { return e.depends_on_space(); };
  return std::any_of(value.begin(), value.end(), varies) ? Variation::in_space : Variation::uniform;
}

DeadLoad::DeadLoad(const NodeLayout& layout, LoadSamples samples, std::array<Expression, 3> value)
    : layout_(layout),
      num_owned_nodes_(layout.num_owned_nodes),
      size_(3 * static_cast<std::size_t>(layout.num_local_nodes)),
      value_(std::move(value)),
      samples_(std::move(samples)) {
  if (variation_of(value_) == Variation::uniform) {
    nodal_weights_.assign(layout.num_local_nodes, 0.0);
    const bool has_few_points = samples_.points_per_item < samples_.nodes_per_item;
    if (!samples_.cells.empty() && !has_few_points) cell_weights_.assign(samples_.nodes.size(), 0.0);
    for (std::size_t p = 0; p < samples_.weights.size(); ++p) {
      const std::size_t item = p / samples_.points_per_item, q = p % samples_.points_per_item;
      for (int a = 0; a < samples_.nodes_per_item; ++a) {
        const std::size_t place = item * samples_.nodes_per_item + a;
        const double weight = samples_.weights[p] * samples_.shapes[q][a];
        nodal_weights_[samples_.nodes[place]] += weight;
        if (!cell_weights_.empty()) cell_weights_[place] += weight;
      }
    }
    LoadSamples of_cells{samples_.nodes_per_item, samples_.points_per_item, {}, std::move(samples_.cells), {}, {}, {}};
    if (!of_cells.cells.empty() && has_few_points) {
      of_cells.shapes = std::move(samples_.shapes);
      of_cells.weights = std::move(samples_.weights);
    }
    samples_ = std::move(of_cells);
  } else if (!depends_on_time() && std::ranges::none_of(value_, &Expression::is_replaceable)) {
    constant_ = sampled(0.0);
    samples_ = {};
  }
}

bool DeadLoad::depends_on_time() const {
  return std::any_of(value_.begin(), value_.end(), [](const Expression& e) { return e.depends_on_time(); });
}

template <class Add>
void DeadLoad::for_each_force(double time, Add add) const {
  if (!constant_.empty()) {
    for (PetscInt i = 0; i < 3 * num_owned_nodes_; ++i) add(i, constant_[i]);
  } else if (!nodal_weights_.empty()) {
    for (int i = 0; i < 3; ++i) {
      const double density = value_[i](0.0, 0.0, 0.0, time);
      for (PetscInt a = 0; a < num_owned_nodes_; ++a) add(3 * a + i, density * nodal_weights_[a]);
    }
  } else if (depends_on_time()) {
    for_each_sample(time, add);
  } else {  // replaceable, and added in the order of `constant_`, to the last bit
    const std::vector<double> forces = sampled(time);
    for (PetscInt i = 0; i < 3 * num_owned_nodes_; ++i) add(i, forces[i]);
  }
}

template <class Add>
void DeadLoad::for_each_sample(double time, Add add) const {
  for (std::size_t p = 0; p < samples_.weights.size(); ++p) {
    const std::size_t item = p / samples_.points_per_item, q = p % samples_.points_per_item;
    const auto& [x, y, z] = samples_.points[p];
    for (int i = 0; i < 3; ++i) {
      const double density = samples_.weights[p] * value_[i](x, y, z, time);
      for (int a = 0; a < samples_.nodes_per_item; ++a) {
        const PetscInt node = samples_.nodes[item * samples_.nodes_per_item + a];
        if (node < num_owned_nodes_) add(3 * node + i, density * samples_.shapes[q][a]);
      }
    }
  }
}

std::vector<double> DeadLoad::sampled(double time) const {
  std::vector<double> f(size_, 0.0);
  for_each_sample(time, [&](PetscInt i, double force) { f[i] += force; });
  return f;
}

std::vector<double> DeadLoad::forces(double time) const {
  std::vector<double> f(size_, 0.0);
  for_each_force(time, [&](PetscInt i, double force) { f[i] += force; });
  return f;
}

double DeadLoad::value(const LocalStage& stage, std::span<const double> q) const {
  CompensatedSum<double> total;
  for_each_force(stage.time, [&](PetscInt i, double force) { total.add(-force * (q[i] - stage.q0[i])); });
  return stage.load_factor * total.total();
}

double DeadLoad::energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const {
  CompensatedSum<double> total;
  for_each_force(at.time, [&](PetscInt i, double force) { total.add(-force * q[i]); });
  return at.load_factor * total.total();
}

void DeadLoad::add_cell_works(const LocalStage& stage, std::span<const double> /*q*/, std::span<const double> d,
                              std::span<double> works) const {
  if (nodal_weights_.empty()) return;
  std::array<double, 3> density{};
  for (std::size_t i = 0; i < 3; ++i) density[i] = stage.load_factor * value_[i](0.0, 0.0, 0.0, stage.time);
  for (std::size_t item = 0; item < samples_.cells.size(); ++item) {
    const PetscInt cell = samples_.cells[item];
    const auto nodes = layout_.nodes_of_cell(cell);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const double* const at = d.data() + 3 * static_cast<std::size_t>(nodes[a]);
      const double along = density[0] * at[0] + density[1] * at[1] + density[2] * at[2];
      works[static_cast<std::size_t>(cell)] -= weight_in_cell(item, a) * along;
    }
  }
}

double DeadLoad::weight_in_cell(std::size_t item, std::size_t node) const {
  if (!cell_weights_.empty()) return cell_weights_[item * static_cast<std::size_t>(samples_.nodes_per_item) + node];
  const auto num_points = static_cast<std::size_t>(samples_.points_per_item);
  double weight = 0.0;
  for (std::size_t q = 0; q < num_points; ++q)
    weight += samples_.weights[item * num_points + q] * samples_.shapes[q][node];
  return weight;
}

void DeadLoad::add_gradient(const LocalStage& stage, std::span<const double>, std::span<double> r) const {
  for_each_force(stage.time, [&](PetscInt i, double force) { r[i] -= stage.load_factor * force; });
}

}  // namespace pliant
