#include "energy/volume/prony.hpp"

#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/point_tensor.hpp"
#include "material/kinematics.hpp"
#include "material/projection.hpp"

#include <array>

namespace pliant {
namespace {

using Symmetric = std::array<Pack, num_symmetric>;

bool is_small_strain(const LawField& elastic) {
  return elastic.traits().constant_tangent;
}

Tensor3<Pack> inverse(const Tensor3<Pack>& F) {
  return (1.0 / det(F)) * transpose(cofactor(F));
}

Tensor3<Pack> strain_of(const LawField& elastic, const Tensor3<Pack>& H) {
  return is_small_strain(elastic) ? small_strain(H) : green_lagrange(H);
}

/// S_e = F^-1 P_e, or the stress itself of a law of small strain.
Tensor3<Pack> stress_of(const LawField& elastic, std::size_t n, const Tensor3<Pack>& H) {
  const Tensor3<Pack> P = elastic.P(n, H);
  return is_small_strain(elastic) ? P : matmul(inverse(add_to_diagonal(H, 1.0)), P);
}

/// The symmetric tensor of unit size in the k-th component.
Tensor3<Pack> unit(int k) {
  const double size = k < 3 ? 1.0 : 0.5;
  Tensor3<Pack> D{};
  D(symmetric_rows[k], symmetric_columns[k]) = D(symmetric_columns[k], symmetric_rows[k]) = size;
  return D;
}

Symmetric components(const Tensor3<Pack>& S) {
  Symmetric s;
  for (int k = 0; k < num_symmetric; ++k) s[k] = S(symmetric_rows[k], symmetric_columns[k]);
  return s;
}

/// C_kl = unit_k : dS(unit_l), symmetric and positive definite where psi_e is convex in E. dE = sym(F^T dF) of dF =
/// F^-T dE, and dS = F^-1 (dP - dF S).
struct Stiffness {
  std::array<Symmetric, num_symmetric> C;

  Stiffness(const LawField& elastic, std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& S) {
    Tangent<Pack> A;
    elastic.tangent(n, H, A);
    const Tensor3<Pack> G = is_small_strain(elastic) ? identity<Pack>() : inverse(add_to_diagonal(H, 1.0));
    for (int l = 0; l < num_symmetric; ++l) {
      const Tensor3<Pack> dF = matmul(transpose(G), unit(l));
      Tensor3<Pack> dP{};
      for (int p = 0; p < 9; ++p) {
        for (int q = 0; q < 9; ++q) dP.a[p] += A[9 * p + q] * dF.a[q];
      }
      const Symmetric dS = components(is_small_strain(elastic) ? dP : matmul(G, dP - matmul(dF, S)));
      for (int k = 0; k < num_symmetric; ++k) C[k][l] = dS[k];
    }
  }

  /// Solves C x = b by elimination without pivoting.
  Symmetric solve(Symmetric b) const {
    auto U = C;
    for (int k = 0; k < num_symmetric; ++k) {
      for (int i = k + 1; i < num_symmetric; ++i) {
        const Pack factor = U[i][k] / U[k][k];
        for (int j = k; j < num_symmetric; ++j) U[i][j] -= factor * U[k][j];
        b[i] -= factor * b[k];
      }
    }
    for (int k = num_symmetric - 1; k >= 0; --k) {
      for (int j = k + 1; j < num_symmetric; ++j) b[k] -= U[k][j] * b[j];
      b[k] /= U[k][k];
    }
    return b;
  }
};

}  // namespace

BranchState branch_state(const LawField& elastic, std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& A) {
  constexpr int most_iterations = 40;
  constexpr double longest = 0.3;     // of F^-1 dF: a law with a barrier stays within it
  constexpr double accuracy = 1e-14;  // of the strain
  Tensor3<Pack> at = H;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Tensor3<Pack> S = stress_of(elastic, n, at);
    const Symmetric x = Stiffness(elastic, n, at, S).solve(components(A - S));
    Tensor3<Pack> dE{};
    for (int k = 0; k < num_symmetric; ++k) dE = dE + x[k] * unit(k);
    const Tensor3<Pack> G = is_small_strain(elastic) ? identity<Pack>() : inverse(add_to_diagonal(at, 1.0));
    const Tensor3<Pack> dF = matmul(transpose(G), dE);
    const Tensor3<Pack> relative = matmul(G, dF);
    const Pack size = 1.0 / (longest * longest) * dot(relative, relative);
    at = at + select(size > 1.0, 1.0 / size, Pack(1.0)) * dF;
    const Tensor3<Pack> E = strain_of(elastic, at);
    if (!any_of(dot(dE, dE) > accuracy * accuracy * (accuracy + dot(E, E)))) break;
  }
  const Tensor3<Pack> elongation = strain_of(elastic, H) - strain_of(elastic, at);
  return {elastic.psi(n, H) - elastic.psi(n, at) - dot(A, elongation), elongation};
}

namespace {

template <int Order>
class PronyTerm final : public StressTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  PronyTerm(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic, BodyCells<Order> cells)
      : branches_(std::move(branches)),
        elastic_(std::move(elastic)),
        cells_(std::move(cells)),
        num_per_branch_(num_symmetric * cells_.num_points()) {}

  std::string_view name() const override { return Prony::name; }
  TermDeclaration declaration() const override { return {.dissipates = true}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, u0 = batch.values(stage.reference()),
              du = batch.change(q, stage.reference())](const Point& point) {
        const Tensor3<Pack> H0 = point.gradient(u0), dH = point.gradient(du);
        const Tensor3<Pack> dE = is_small_strain(*elastic_) ? small_strain(dH) : green_lagrange_change(H0, dH);
        return weight(stage.dt) * elastic_->psi_change(point.index(), H0, dH) - dot(forgotten(stage, point), dE);
      };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const auto stress = [&](const Batch& batch) {
      return [this, &stage, u = batch.values(q)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u), A = forgotten(stage, point);
        const Tensor3<Pack> FA = is_small_strain(*elastic_) ? A : A + matmul(H, A);
        return weight(stage.dt) * elastic_->P(point.index(), H) - FA;
      };
    };
    cells_.add_forces(stress, r);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto tangent_of = [&](const Batch& batch) {
      return [this, &stage, projection, u = batch.values(q)](const Point& point) {
        Tangent<Pack> A;
        elastic_->tangent(point.index(), point.gradient(u), A);
        for (Pack& entry : A) entry *= weight(stage.dt);
        if (!is_small_strain(*elastic_)) subtract(forgotten(stage, point), A);
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  std::size_t num_internal() const override { return branches_.size() * num_per_branch_; }

  void place_internal(std::span<InternalPlace> places) const override {
    const std::size_t num_points = cells_.num_points();
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      place_symmetric(cells_, static_cast<int>(i), places.subspan(i * num_points, num_points));
    }
  }

  void end_stage(const LocalStage& stage, std::span<const double> q, std::span<double> z) const override {
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const Tensor3<Pack> S = stress_of(*elastic_, point.index(), point.gradient(u));
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          store_symmetric(point, ended(i, stage, point, S), branch(i, z));
        }
      }
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, z, u = batch.values(q)](const Point& point) {
        Pack total = 0.0;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = load_symmetric(point, branch(i, z));
          total += branches_[i].ratio * branch_state(*elastic_, point.index(), point.gradient(u), A).energy;
        }
        return total;
      };
    });
  }

  StressPart part() const override { return StressPart::viscous; }

  /// sum_i H_i, and what the branches store.
  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const auto at_points = [&](const Batch& batch) {
      return [&, u = batch.values(state.q)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u), S = stress_of(*elastic_, point.index(), H);
        PointStress total;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = load_symmetric(point, branch(i, state.z));
          total.S = total.S + branches_[i].ratio * (S - A);
          total.energy += branches_[i].ratio * branch_state(*elastic_, point.index(), H, A).energy;
        }
        return total;
      };
    };
    const bool is_small = is_small_strain(*elastic_);
    visit_mean_stresses(cells_, state.q, is_small ? StressMeasure::small_strain : StressMeasure::second_piola_kirchhoff,
                        at_points, visit);
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, u = batch.values(q)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u), S = stress_of(*elastic_, point.index(), H);
        Pack total = 0.0;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = ended(i, stage, point, S);
          const BranchState state = branch_state(*elastic_, point.index(), H, A);
          total += branches_[i].ratio / branches_[i].relaxation_time * dot(S - A, state.elongation);
        }
        return total;
      };
    });
  }

 private:
  /// c_i.
  double weight(std::size_t i, double dt) const {
    return branches_[i].ratio * branches_[i].relaxation_time / (branches_[i].relaxation_time + dt);
  }
  double weight(double dt) const {
    double total = 0.0;
    for (std::size_t i = 0; i < branches_.size(); ++i) total += weight(i, dt);
    return total;
  }
  /// sum_i c_i A_i0.
  Tensor3<Pack> forgotten(const LocalStage& stage, const Point& point) const {
    Tensor3<Pack> total{};
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      total = total + weight(i, stage.dt) * load_symmetric(point, branch(i, stage.z0));
    }
    return total;
  }
  /// A_i at the end of the stage, at the elastic stress S.
  Tensor3<Pack> ended(std::size_t i, const LocalStage& stage, const Point& point, const Tensor3<Pack>& S) const {
    const Tensor3<Pack> A0 = load_symmetric(point, branch(i, stage.z0));
    return A0 + stage.dt / (branches_[i].relaxation_time + stage.dt) * (S - A0);
  }
  /// A_iJkL -= d_ik B_JL.
  static void subtract(const Tensor3<Pack>& B, Tangent<Pack>& A) {
    for (int i = 0; i < 3; ++i) {
      for (int J = 0; J < 3; ++J) {
        for (int L = 0; L < 3; ++L) A[9 * (3 * i + J) + 3 * i + L] -= B(J, L);
      }
    }
  }
  template <class T>
  std::span<T> branch(std::size_t i, std::span<T> z) const {
    return z.subspan(i * num_per_branch_, num_per_branch_);
  }

  std::vector<Prony> branches_;
  std::shared_ptr<const LawField> elastic_;
  BodyCells<Order> cells_;
  std::size_t num_per_branch_;  // internal variables
};

}  // namespace

template <int Order>
std::unique_ptr<EnergyTerm> make_prony_term(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic,
                                            const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes) {
  return std::make_unique<PronyTerm<Order>>(std::move(branches), std::move(elastic),
                                            BodyCells<Order>(groups, body, num_owned_nodes));
}

template std::unique_ptr<EnergyTerm> make_prony_term<1>(std::vector<Prony>, std::shared_ptr<const LawField>,
                                                        const CellGroups<1>&, int, PetscInt);
template std::unique_ptr<EnergyTerm> make_prony_term<2>(std::vector<Prony>, std::shared_ptr<const LawField>,
                                                        const CellGroups<2>&, int, PetscInt);

}  // namespace pliant
