#include "fem/patch_recovery.hpp"

#include "base/vector3.hpp"
#include "fem/cell_integration.hpp"
#include "fem/element.hpp"
#include "petsc/collective.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Eigenvalues>
#include <map>
#include <utility>

namespace pliant {
namespace {

/// Numbers of monomials up to the degrees 0, 1 and 2.
constexpr std::array<int, 3> terms_of_degree{1, 4, 10};
/// Below this the normal equations, with columns of unit length, count as singular.
constexpr double least_eigenvalue = 1e-5;
/// The largest Samples::trusted_gain of a polynomial at its own vertex; beyond it the degree is lowered. The four
/// points of a single cell reach 4 at its corners.
constexpr double largest_gain = 5.0;

/// Adds the ghosts' numbers to those of their owners, and then updates the ghosts. [node][component]. Collective.
void sum_over_ranks(const NodeLayout& layout, std::span<double> values, std::size_t width) {
  const Handle<Vec> v = make_vector(layout);
  for (std::size_t first = 0; first < width; first += 3) {
    const std::size_t count = std::min<std::size_t>(3, width - first);
    const auto for_each_number = [&](const auto& f) {
      const GhostedView view(v.get());
      for (PetscInt n = 0; n < layout.num_local_nodes; ++n) {
        for (std::size_t c = 0; c < count; ++c) f(values[width * n + first + c], view.span()[3 * n + c]);
      }
    };
    for_each_number([](const double& here, double& there) { there = here; });
    check(VecGhostUpdateBegin(v.get(), ADD_VALUES, SCATTER_REVERSE));
    check(VecGhostUpdateEnd(v.get(), ADD_VALUES, SCATTER_REVERSE));
    update_ghosts(v.get());
    for_each_number([](double& here, const double& there) { here = there; });
  }
}

}  // namespace

PatchRecovery::PatchRecovery(const NodeLayout& layout, std::span<const int> body_of_cell, Samples samples)
    : layout_(layout), samples_(std::move(samples)) {
  std::map<std::pair<PetscInt, int>, std::vector<PetscInt>> cells_around;  // of an owned vertex, by body
  for (PetscInt cell = 0; cell < layout.num_local_cells; ++cell) {
    if (body_of_cell[cell] < 0) continue;
    for (const PetscInt n : layout.nodes_of_cell(cell).first(4)) {
      if (n < layout.num_owned_nodes) cells_around[std::pair(n, body_of_cell[cell])].push_back(cell);
    }
  }
  for (const auto& [of, cells] : cells_around) {
    Patch patch{.body = of.second, .first_cell = cells_.size(), .first_node = nodes_.size(), .num_cells = cells.size()};
    cells_.insert(cells_.end(), cells.begin(), cells.end());
    nodes_.push_back(of.first);
    std::vector<PetscInt> on_edges, others;
    for (const PetscInt cell : cells) {
      const auto nodes = layout.nodes_of_cell(cell);
      others.insert(others.end(), nodes.begin(), nodes.end());
      for (std::size_t e = 0; e < tet_edges.size() && layout.order == 2; ++e) {
        if (nodes[tet_edges[e][0]] == of.first || nodes[tet_edges[e][1]] == of.first) on_edges.push_back(nodes[4 + e]);
      }
    }
    const auto add = [&](std::vector<PetscInt>& more) {
      std::ranges::sort(more);
      const auto rest = std::ranges::unique(more);
      more.erase(rest.begin(), rest.end());
      nodes_.insert(nodes_.end(), more.begin(), more.end());
    };
    add(on_edges);
    patch.num_own = 1 + on_edges.size();
    std::erase_if(others, [&](PetscInt n) { return n == of.first || std::ranges::binary_search(on_edges, n); });
    add(others);
    patch.num_nodes = nodes_.size() - patch.first_node;
    fit(patch);
    patches_.push_back(patch);
  }
  colour_bodies();
}

void PatchRecovery::colour_bodies() {
  using Pair = std::array<int, 2>;
  std::vector<Pair> mine;
  int last = -1;
  for (std::size_t p = 0; p < patches_.size(); ++p) {
    last = std::max(last, patches_[p].body);
    for (std::size_t q = p; q-- > 0 && nodes_[patches_[q].first_node] == nodes_[patches_[p].first_node];) {
      mine.push_back({patches_[q].body, patches_[p].body});
    }
  }
  std::ranges::sort(mine);
  const auto rest = std::ranges::unique(mine);
  mine.erase(rest.begin(), rest.end());
  const std::vector<Pair> pairs = gathered(layout_.comm, mine);
  const auto num_bodies = 1 + static_cast<int>(maximum(layout_.comm, static_cast<double>(last)));
  for (int body = 0; body < num_bodies; ++body) {
    std::vector<char> is_used(static_cast<std::size_t>(num_colours_) + 1, 0);
    for (const auto& [a, b] : pairs) {
      if (a == body && b < body) is_used[static_cast<std::size_t>(colour_of_body_[static_cast<std::size_t>(b)])] = 1;
      if (b == body && a < body) is_used[static_cast<std::size_t>(colour_of_body_[static_cast<std::size_t>(a)])] = 1;
    }
    colour_of_body_.push_back(static_cast<int>(std::ranges::find(is_used, 0) - is_used.begin()));
    num_colours_ = std::max(num_colours_, colour_of_body_.back() + 1);
  }
}

std::vector<std::array<double, 3>> PatchRecovery::sample_positions(const Patch& patch) const {
  std::vector<std::array<double, 3>> at;
  for (std::size_t c = 0; c < patch.num_cells; ++c) {
    for (const auto& xi : samples_.points) at.push_back(position_in_cell(layout_, cells_[patch.first_cell + c], xi));
  }
  return at;
}

std::array<double, PatchRecovery::most_terms> PatchRecovery::terms_at(const Patch& patch,
                                                                      const std::array<double, 3>& X) const {
  const auto [x, y, z] = (1.0 / patch.size) * (X - patch.centre);
  return {1.0, x, y, z, x * x, y * y, z * z, x * y, y * z, x * z};
}

void PatchRecovery::fit(Patch& patch) {
  const auto at = sample_positions(patch);
  for (const auto& X : at) patch.centre = patch.centre + (1.0 / static_cast<double>(at.size())) * X;
  patch.size = 0.0;
  for (const auto& X : at) patch.size = std::max(patch.size, norm(X - patch.centre));
  if (patch.size == 0.0) patch.size = 1.0;  // a single point
  patch.first_number = inverses_.size();
  int degree = samples_.degree;
  while (!can_fit(patch, at, terms_of_degree[static_cast<std::size_t>(degree)])) --degree;
}

/// Stores the inverse of the normal equations unless they are near singular or would magnify errors. The mean alone
/// always fits.
bool PatchRecovery::can_fit(Patch& patch, std::span<const std::array<double, 3>> at, int num_terms) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num_terms, num_terms);
  if (static_cast<std::size_t>(num_terms) > at.size()) return false;
  for (const auto& X : at) {
    const auto terms = terms_at(patch, X);
    const Eigen::Map<const Eigen::VectorXd> row(terms.data(), num_terms);
    normal += row * row.transpose();
  }
  const Eigen::VectorXd lengths = normal.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd scale = lengths.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scale.asDiagonal() * normal * scale.asDiagonal());
  if (num_terms > 1 && !(eigen.eigenvalues()[0] > least_eigenvalue)) return false;
  const Eigen::MatrixXd inverse = scale.asDiagonal() * eigen.eigenvectors() *
                                  eigen.eigenvalues().cwiseInverse().asDiagonal() * eigen.eigenvectors().transpose() *
                                  scale.asDiagonal();
  const auto of_vertex = terms_at(patch, layout_.position(nodes_[patch.first_node]));
  const Eigen::Map<const Eigen::VectorXd> row(of_vertex.data(), num_terms);
  if (num_terms > 1 && !(row.dot(inverse * row) < largest_gain)) return false;
  patch.num_terms = num_terms;
  inverses_.insert(inverses_.end(), inverse.data(), inverse.data() + inverse.size());
  return true;
}

bool PatchRecovery::has_degree(const Patch& patch) const {
  return patch.num_terms == terms_of_degree[static_cast<std::size_t>(samples_.degree)];
}

/// Adds the polynomial's values at the patch's nodes, and 1 after them, to the sums of their merit.
void PatchRecovery::evaluate(const Patch& patch, std::span<const double> values, std::size_t width,
                             std::array<std::vector<double>, num_merits>& sums) const {
  const auto num_terms = static_cast<std::size_t>(patch.num_terms);
  const std::size_t num_points = samples_.points.size();
  const auto at = sample_positions(patch);
  std::vector<double> moments(num_terms * width, 0.0), coefficients(num_terms * width, 0.0);
  for (std::size_t s = 0; s < at.size(); ++s) {
    const auto terms = terms_at(patch, at[s]);
    const auto cell = static_cast<std::size_t>(cells_[patch.first_cell + s / num_points]);
    const double* value = &values[width * (num_points * cell + s % num_points)];
    for (std::size_t t = 0; t < num_terms; ++t) {
      for (std::size_t c = 0; c < width; ++c) moments[width * t + c] += terms[t] * value[c];
    }
  }
  for (std::size_t t = 0; t < num_terms; ++t) {
    for (std::size_t s = 0; s < num_terms; ++s) {
      const double entry = inverses_[patch.first_number + num_terms * t + s];
      for (std::size_t c = 0; c < width; ++c) coefficients[width * t + c] += entry * moments[width * s + c];
    }
  }
  const bool is_good = has_degree(patch);
  for (std::size_t k = 0; k < (is_good ? patch.num_nodes : patch.num_own); ++k) {
    const PetscInt node = nodes_[patch.first_node + k];
    const auto terms = terms_at(patch, layout_.position(node));
    double gain = 0.0;
    for (std::size_t t = 0; t < num_terms; ++t) {
      for (std::size_t u = 0; u < num_terms; ++u) {
        gain += terms[t] * inverses_[patch.first_number + num_terms * t + u] * terms[u];
      }
    }
    const bool is_trusted = is_good && gain < samples_.trusted_gain, is_own = k < patch.num_own;
    if (!is_own && !is_trusted) continue;
    const Merit merit = !is_own ? of_neighbour : is_trusted ? own : lowered;
    double* sum = &sums[merit][(width + 1) * static_cast<std::size_t>(node)];
    for (std::size_t t = 0; t < num_terms; ++t) {
      for (std::size_t c = 0; c < width; ++c) sum[c] += terms[t] * coefficients[width * t + c];
    }
    sum[width] += 1.0;
  }
}

PatchRecovery::AtNodes PatchRecovery::at_nodes(std::span<const double> values, int components,
                                               std::span<const char> is_taken) const {
  const auto width = static_cast<std::size_t>(components), all = width + 1;  // and how many values were added
  const auto num_nodes = static_cast<std::size_t>(layout_.num_local_nodes);
  AtNodes result{std::vector<double>(width * num_nodes, 0.0), std::vector<char>(num_nodes, 0)};
  std::vector<double> num_bodies(num_nodes, 0.0);
  for (int colour = 0; colour < num_colours_; ++colour) {
    std::array<std::vector<double>, num_merits> sums;
    for (auto& of_merit : sums) of_merit.assign(all * num_nodes, 0.0);
    for (const Patch& patch : patches_) {
      const auto body = static_cast<std::size_t>(patch.body);
      if (is_taken[body] != 0 && colour_of_body_[body] == colour) evaluate(patch, values, width, sums);
    }
    std::vector<char> is_found(num_nodes, 0);  // by a better merit
    for (auto& of_merit : sums) {
      sum_over_ranks(layout_, of_merit, all);
      for (std::size_t n = 0; n < num_nodes; ++n) {
        const double count = of_merit[all * n + width];
        if (is_found[n] != 0 || count == 0.0) continue;
        is_found[n] = result.has_value[n] = 1;
        num_bodies[n] += 1.0;
        for (std::size_t c = 0; c < width; ++c) result.values[width * n + c] += of_merit[all * n + c] / count;
      }
    }
  }
  for (std::size_t n = 0; n < num_nodes; ++n) {
    for (std::size_t c = 0; c < width && num_bodies[n] > 1.0; ++c) result.values[width * n + c] /= num_bodies[n];
  }
  return result;
}

}  // namespace pliant
