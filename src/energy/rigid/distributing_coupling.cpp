#include "energy/rigid/distributing_coupling.hpp"

#include "fem/straight_cell.hpp"
#include "petsc/collective.hpp"

#include <algorithm>

namespace pliant {
namespace {

struct NodesSeen final : PairFeatures {
  std::vector<PetscInt> local;
};

Vector3<double> axial(const Tensor3<double>& A) {
  return {A(1, 2) - A(2, 1), A(2, 0) - A(0, 2), A(0, 1) - A(1, 0)};
}

Vector3<double> axis(std::size_t i) {
  Vector3<double> e{};
  e[i] = 1.0;
  return e;
}

}  // namespace

DistributingCoupling::DistributingCoupling(const NodeLayout& layout, const SurfaceMean& surface, const JointBody& body,
                                           double stiffness)
    : J_(surface.second_moment), stiffness_(stiffness) {
  const Tensor3<double> moment = surface.rotational_moment();
  inverse_ = (1.0 / det(moment)) * transpose(cofactor(moment));
  std::vector<Member> mine;
  for (const NodeOfSurface& at : surface.nodes) {
    mine.push_back({layout.global_node(at.node), at.share, at.moment, {}});
  }
  if (!body.nodes.empty()) {
    std::array<Vector3<double>, 4> X;
    for (std::size_t a = 0; a < 4; ++a) X[a] = layout.position(body.nodes[a]);
    const auto gradients = linear_gradients(X);
    for (std::size_t a = 0; a < 4; ++a) {
      if (body.nodes[a] >= layout.num_owned_nodes) continue;
      const double N = (a == 0 ? 1.0 : 0.0) + dot(gradients[a], surface.middle - X[0]);
      mine.push_back({layout.global_node(body.nodes[a]), -N, {}, gradients[a]});
    }
  }
  while (mine.size() % nodes_per_patch != 0) mine.push_back({mine.back().global_node, 0.0, {}, {}});
  members_ = gathered(layout.comm, mine);
  make_patches(layout);
}

void DistributingCoupling::make_patches(const NodeLayout& layout) {
  patches_.nodes_per_patch = nodes_per_patch;
  for (std::size_t first = 0; first < members_.size(); first += nodes_per_patch) {
    const PetscInt owned = members_[first].global_node - layout.first_global_node;
    if (owned < 0 || owned >= layout.num_owned_nodes) continue;
    if (first == 0) is_counted_ = true;
    for (const int tag : {original, copy}) {
      for (std::size_t k = 0; k < nodes_per_patch; ++k) {
        patches_.nodes.push_back(members_[first + k].global_node - layout.first_global_node);
      }
      patches_.keys.push_back(2 * static_cast<std::int64_t>(first / nodes_per_patch) + tag);
      patches_.tags.push_back(tag);
      patches_.is_owned.push_back(1);
    }
  }
}

bool DistributingCoupling::couples(std::int64_t key, std::int64_t other) const {
  return (key % 2 == original && other % 2 == original) || key / 2 == other / 2;
}

std::shared_ptr<const PairFeatures> DistributingCoupling::features_of(const NearPatches& near) const {
  auto seen = std::make_shared<NodesSeen>();
  if (near.patches.size() == 0) return seen;
  seen->local.resize(members_.size());
  for (std::size_t p = 0; p < near.patches.size(); ++p) {
    if (near.patches.tags[p] != original) continue;
    const auto first = static_cast<std::ptrdiff_t>(near.patches.keys[p] / 2 * nodes_per_patch);
    std::ranges::copy(near.patches.nodes_of(p), seen->local.begin() + first);
  }
  return seen;
}

std::span<const PetscInt> DistributingCoupling::nodes(const NearPatches& near) {
  return static_cast<const NodesSeen&>(*near.features).local;
}

TermDeclaration DistributingCoupling::declaration() const {
  TermDeclaration declaration;
  declaration.rotates_with_body = false;
  return declaration;
}

DistributingCoupling::Motion DistributingCoupling::motion(const NearPatches& near, std::span<const double> q,
                                                          std::span<const double> from) const {
  const auto local = nodes(near);
  Motion result;
  for (std::size_t n = 0; n < local.size(); ++n) {
    const auto& [number, c, b, g] = members_[n];
    const auto i = 3 * static_cast<std::size_t>(local[n]);
    Vector3<double> u{q[i], q[i + 1], q[i + 2]};
    if (!from.empty()) u = u - Vector3<double>{from[i], from[i + 1], from[i + 2]};
    result.d = result.d + c * u;
    result.H = result.H + outer(u, b);
    result.G = result.G + outer(u, g);
  }
  return result;
}

// J is symmetric: M^T F - J = H^T + J G + H^T G, which keeps the digits of small displacements.
Vector3<double> DistributingCoupling::turn(const Motion& at) const {
  return axial(transpose(at.H) + matmul(J_, at.G) + matmul(transpose(at.H), at.G));
}

// a - a0 = axial(h^T F + M0^T g), h and g the changes of M and F.
double DistributingCoupling::value(const LocalStage& stage, std::span<const double> q) const {
  if (!is_counted_) return 0.0;
  const Motion now = motion(*stage.near, q), then = motion(*stage.near, stage.reference()),
               change = motion(*stage.near, q, stage.reference());
  const Vector3<double> turned = axial(transpose(change.H) + matmul(transpose(change.H), now.G) + matmul(J_, change.G) +
                                       matmul(transpose(then.H), change.G));
  return 0.5 * stiffness_ * (dot(change.d, now.d + then.d) + dot(turned, matvec(inverse_, turn(now) + turn(then))));
}

double DistributingCoupling::energy_at(const Instant& at, std::span<const double> q,
                                       std::span<const double> /*z*/) const {
  if (!is_counted_) return 0.0;
  const Motion now = motion(*at.near, q);
  const Vector3<double> a = turn(now);
  return 0.5 * stiffness_ * (dot(now.d, now.d) + dot(a, matvec(inverse_, a)));
}

// dV = k d . dd + tau . da, tau = k J_r^-1 a, tau . da = sum dx . (F (tau x b) + M (g x tau)).
void DistributingCoupling::add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const {
  const auto local = nodes(*stage.near);
  if (local.empty()) return;
  const Motion now = motion(*stage.near, q);
  const Tensor3<double> F = add_to_diagonal(now.G, 1.0), M = J_ + now.H;
  const Vector3<double> force = stiffness_ * now.d, tau = stiffness_ * matvec(inverse_, turn(now));
  for (std::size_t n = 0; n < local.size(); ++n) {
    if (!stage.near->is_owned(local[n])) continue;
    const auto& [number, c, b, g] = members_[n];
    const Vector3<double> f = c * force + matvec(F, cross(tau, b)) + matvec(M, cross(g, tau));
    for (std::size_t i = 0; i < 3; ++i) r[3 * static_cast<std::size_t>(local[n]) + i] += f[i];
  }
}

// With D_n = da/dx_n, columns F (e_i x b_n) + M (g_n x e_i): K_nm = k (c_n c_m I + D_n^T J_r^-1 D_m) + tau . d2a, where
// tau . d2a = (b_n . (g_m x tau) + b_m . (g_n x tau)) I.
void DistributingCoupling::add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                                       Projection projection) const {
  const auto local = nodes(*stage.near);
  if (local.empty()) return;
  const Motion now = motion(*stage.near, q);
  const Tensor3<double> F = add_to_diagonal(now.G, 1.0), M = J_ + now.H;
  const bool is_exact = projection == Projection::none;
  const Vector3<double> tau = is_exact ? stiffness_ * matvec(inverse_, turn(now)) : Vector3<double>{};
  std::vector<Tensor3<double>> slopes;
  for (const Member& member : members_) {
    std::array<Vector3<double>, 3> columns;
    for (std::size_t i = 0; i < 3; ++i) {
      columns[i] = matvec(F, cross(axis(i), member.b)) + matvec(M, cross(member.g, axis(i)));
    }
    slopes.push_back(
        make_tensor([&](int i, int j) { return columns[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)]; }));
  }
  for (std::size_t n = 0; n < local.size(); ++n) {
    if (!stage.near->is_owned(local[n])) continue;
    const Member& row = members_[n];
    const Tensor3<double> weighted = stiffness_ * matmul(slopes[n], inverse_);
    const Vector3<double> twist = cross(row.g, tau);
    for (std::size_t m = 0; m < local.size(); ++m) {
      const Member& column = members_[m];
      const double along = stiffness_ * row.c * column.c + dot(row.b, cross(column.g, tau)) + dot(column.b, twist);
      const Tensor3<double> block = add_to_diagonal(matmul(weighted, transpose(slopes[m])), along);
      K.add(local[n], local[m], block.a);
    }
  }
}

}  // namespace pliant
