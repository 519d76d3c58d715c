#include "energy/rod/fibres.hpp"

#include "base/compensated_sum.hpp"
#include "petsc/collective.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <stdexcept>

namespace pliant {
namespace {

/// Local nodes that are corners of cells, by their places.
std::map<std::array<double, 3>, PetscInt> corners_by_place(const NodeLayout& layout) {
  std::map<std::array<double, 3>, PetscInt> result;
  for (PetscInt c = 0; c < layout.num_local_cells; ++c) {
    for (const PetscInt node : layout.nodes_of_cell(c).first(4)) result.emplace(layout.position(node), node);
  }
  return result;
}

/// a n n^T + b (I - n n^T), by rows.
std::array<double, 9> along_and_across(const Vector3<double>& n, double a, double b) {
  std::array<double, 9> block{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = (a - b) * n[i] * n[j] + (i == j ? b : 0.0);
  }
  return block;
}

/// r += f at the second node, -f at the first.
void add_force(const LocalFibre& of, const Vector3<double>& f, PetscInt num_owned, std::span<double> r) {
  for (std::size_t end = 0; end < 2; ++end) {
    if (of.nodes[end] >= num_owned) continue;
    const auto first = 3 * static_cast<std::size_t>(of.nodes[end]);
    for (std::size_t i = 0; i < 3; ++i) r[first + i] += end == 0 ? -f[i] : f[i];
  }
}

/// K += block in the blocks of each node with itself, -block in those with the other one.
void add_stiffness(const LocalFibre& of, std::array<double, 9> block, PetscInt num_owned, const BlockWriter& K) {
  for (std::size_t end = 0; end < 2; ++end) {
    if (of.nodes[end] < num_owned) K.add(of.nodes[end], of.nodes[end], block);
  }
  for (double& entry : block) entry = -entry;
  for (std::size_t end = 0; end < 2; ++end) {
    if (of.nodes[end] < num_owned) K.add(of.nodes[end], of.nodes[1 - end], block);
  }
}

}  // namespace

Fibres::Fibres(const NodeLayout& layout, std::span<const FibreSegment> segments)
    : num_owned_nodes_(layout.num_owned_nodes) {
  const auto corners = corners_by_place(layout);
  std::vector<double> num_counted(segments.size(), 0.0);
  for (std::size_t s = 0; s < segments.size(); ++s) {
    const FibreSegment& segment = segments[s];
    const auto first = corners.find(segment.ends[0]), second = corners.find(segment.ends[1]);
    if (first == corners.end() || second == corners.end()) continue;
    LocalFibre fibre;
    fibre.nodes = {first->second, second->second};
    fibre.is_counted = fibre.nodes[0] < num_owned_nodes_;
    if (!fibre.is_counted && fibre.nodes[1] >= num_owned_nodes_) continue;
    fibre.axis = unit(segment.ends[1] - segment.ends[0]);
    fibre.middle = 0.5 * (segment.ends[0] + segment.ends[1]);
    fibre.length = segment.length;
    fibre.axial = segment.axial;
    fibre.mass = segment.mass;
    fibre.damping = segment.damping;
    fibre.number = s;
    if (fibre.is_counted) num_counted[s] = 1.0;
    segments_.push_back(fibre);
  }
  sum_in_place(layout.comm, num_counted);
  if (std::ranges::any_of(num_counted, [](double number) { return number != 1.0; })) {
    throw std::logic_error("a fibre has a segment that does not belong to a cell");
  }
}

// l/2 E A (s^2 - s0^2) = l/2 E A (s - s0) (s + s0), with the digits of small changes.
double Fibres::value(const LocalStage& stage, std::span<const double> q) const {
  CompensatedSum<double> sum;
  const std::span<const double> from = stage.reference();
  for (const LocalFibre& of : segments_) {
    if (!of.is_counted) continue;
    const Vector3<double> h = of.change(q), h0 = of.change(from);
    const double s = FibreStretch(of.axis, h).value, s0 = FibreStretch(of.axis, h0).value;
    const double change = dot(2.0 * of.axis + h + h0, of.change(q, from)) / (2.0 + s + s0);
    sum.add(0.5 * of.length * of.axial * change * (s + s0));
  }
  return std::isfinite(sum.total()) ? sum.total() : std::numeric_limits<double>::infinity();
}

double Fibres::energy(std::span<const double> q, std::span<const double> /*z*/) const {
  CompensatedSum<double> sum;
  for (const LocalFibre& of : segments_) {
    const double s = of.is_counted ? FibreStretch(of.axis, of.change(q)).value : 0.0;
    sum.add(0.5 * of.length * of.axial * s * s);
  }
  return sum.total();
}

void Fibres::add_gradient(const LocalStage& /*stage*/, std::span<const double> q, std::span<double> r) const {
  for (const LocalFibre& of : segments_) {
    const FibreStretch s(of.axis, of.change(q));
    add_force(of, (of.axial * s.value) * s.n, num_owned_nodes_, r);
  }
}

// As in Rods::add_hessian, forces extrapolated along the last step where there is one.
void Fibres::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                         Projection projection) const {
  for (const LocalFibre& of : segments_) {
    const FibreStretch s(of.axis, of.change(q));
    double of_force = s.value;
    if (!stage.previous.empty()) {
      const FibreStretch then(of.axis, of.change(stage.previous));
      of_force = then.value + dot(then.n, of.change(q, stage.previous));
    }
    const double stiffness = of.axial / of.length;
    double across = of_force / (1.0 + s.value);
    if (projection == Projection::positive_semidefinite) across = std::max(across, 0.0);
    add_stiffness(of, along_and_across(s.n, stiffness, stiffness * across), num_owned_nodes_, K);
  }
}

void Fibres::add_masses(const BlockPattern& pattern, Mass mass_kind, MassMatrix& mass) const {
  const bool is_lumped = mass_kind == Mass::lumped;
  for (const LocalFibre& of : segments_) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (of.nodes[end] >= num_owned_nodes_) continue;
      mass.add(pattern.block(of.nodes[end], of.nodes[end]), of.mass / (is_lumped ? 2.0 : 3.0));
      if (!is_lumped) mass.add(pattern.block(of.nodes[end], of.nodes[1 - end]), of.mass / 6.0);
    }
  }
}

std::vector<MassAtNode> Fibres::masses(std::span<const char> of_segments) const {
  std::vector<MassAtNode> result;
  for (const LocalFibre& of : segments_) {
    if (of_segments[of.number] == 0 || of.mass == 0.0) continue;
    for (const PetscInt node : of.nodes) {
      if (node < num_owned_nodes_) result.push_back({node, 0.5 * of.mass, of.middle});
    }
  }
  return result;
}

double Fibres::tension(const LocalFibre& of, std::span<const double> q) {
  return of.axial * FibreStretch(of.axis, of.change(q)).value;
}

void FibreViscosity::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  if (stage.q0.empty() || !(stage.dt > 0.0)) return;
  for (const LocalFibre& of : fibres_.segments_here()) {
    const FibreStretch s(of.axis, of.change(q));
    const double rate = dot(s.n, of.change(q, stage.q0)) / stage.dt;
    add_force(of, (of.axial * of.damping * rate) * s.n, num_owned_nodes_, r);
  }
}

// f = c (n . t') n with dn/dt = P / |t|, P = I - n n^T: df/dt = c (n n^T / dt + n (P t')^T / |t| + (n . t') P / |t|).
void FibreViscosity::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                 Projection projection) const {
  if (stage.q0.empty() || !(stage.dt > 0.0)) return;
  const double exact = projection == Projection::none ? 1.0 : 0.0;
  for (const LocalFibre& of : fibres_.segments_here()) {
    if (of.damping == 0.0) continue;
    const FibreStretch s(of.axis, of.change(q));
    const Vector3<double> velocity = (1.0 / stage.dt) * of.change(q, stage.q0);
    const double rate = dot(s.n, velocity), c = of.axial * of.damping / of.length;
    const double by_length = exact / (1.0 + s.value);
    std::array<double, 9> block = along_and_across(s.n, c / stage.dt, c * rate * by_length);
    const Vector3<double> across = by_length * (velocity - rate * s.n);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] += c * s.n[i] * across[j];
    }
    add_stiffness(of, block, num_owned_nodes_, K);
  }
}

double FibreViscosity::dissipation(const LocalStage& stage, std::span<const double> q) const {
  if (stage.q0.empty() || !(stage.dt > 0.0)) return 0.0;
  double power = 0.0;
  for (const LocalFibre& of : fibres_.segments_here()) {
    if (!of.is_counted) continue;
    const double rate = dot(FibreStretch(of.axis, of.change(q)).n, of.change(q, stage.q0)) / stage.dt;
    power += of.length * of.axial * of.damping * rate * rate;
  }
  return power;
}

}  // namespace pliant
