#include "energy/elastic.hpp"

#include "base/compensated_sum.hpp"
#include "energy/cell_matrix.hpp"
#include "energy/energy_change.hpp"
#include "energy/step_bound.hpp"
#include "material/projection.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// S = P . (dxi/dX)^T: the stress that multiplies gradients on the reference cell.
PLIANT_INLINE Tensor3<Pack> pulled_back(const Tensor3<Pack>& P, const Tensor3<Pack>& inverse_jacobian) {
  return matmul(P, transpose(inverse_jacobian));
}

/// C_{i alpha k beta} = A_{iJkL} (dxi_alpha/dX_J) (dxi_beta/dX_L), at [9 (3 i + alpha) + 3 k + beta].
PLIANT_INLINE Tangent<Pack> pulled_back(const Tangent<Pack>& A, const Tensor3<Pack>& inverse_jacobian) {
  Tangent<Pack> half;
  for (int p = 0; p < 9; ++p) {
    for (int k = 0; k < 3; ++k) {
      for (int beta = 0; beta < 3; ++beta) {
        half[9 * p + 3 * k + beta] = A[9 * p + 3 * k] * inverse_jacobian(beta, 0) +
                                     A[9 * p + 3 * k + 1] * inverse_jacobian(beta, 1) +
                                     A[9 * p + 3 * k + 2] * inverse_jacobian(beta, 2);
      }
    }
  }
  Tangent<Pack> C;
  for (int i = 0; i < 3; ++i) {
    for (int alpha = 0; alpha < 3; ++alpha) {
      for (int q = 0; q < 9; ++q) {
        C[9 * (3 * i + alpha) + q] = half[9 * (3 * i) + q] * inverse_jacobian(alpha, 0) +
                                     half[9 * (3 * i + 1) + q] * inverse_jacobian(alpha, 1) +
                                     half[9 * (3 * i + 2) + q] * inverse_jacobian(alpha, 2);
      }
    }
  }
  return C;
}

/// Block (a, b) += dN_a . C . dN_b.
template <int N>
PLIANT_INLINE void add_blocks(const Tangent<Pack>& C, const std::array<std::array<double, 3>, N>& dN,
                              CellMatrix<N>& matrix) {
  for (int b = 0; b < N; ++b) {
    std::array<Pack, 27> column;  // C . dN_b at [3 (3 i + alpha) + k]
    for (int p = 0; p < 9; ++p) {
      for (int k = 0; k < 3; ++k) {
        column[3 * p + k] =
            C[9 * p + 3 * k] * dN[b][0] + C[9 * p + 3 * k + 1] * dN[b][1] + C[9 * p + 3 * k + 2] * dN[b][2];
      }
    }
    for (int a = 0; a <= b; ++a) {
      Tensor3<Pack>& block = matrix.blocks[CellMatrix<N>::index(a, b)];
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
          block(i, k) +=
              dN[a][0] * column[9 * i + k] + dN[a][1] * column[9 * i + 3 + k] + dN[a][2] * column[9 * i + 6 + k];
        }
      }
    }
  }
}

template <int Order, class Law>
class ElasticTermOf final : public ElasticTerm {
  using Group = CellGroup<Order>;
  static constexpr int num_nodes = Group::num_nodes;

 public:
  ElasticTermOf(const Law& law, const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes)
      : law_(law), num_owned_nodes_(num_owned_nodes) {
    for (const Group& group : groups) {
      if (group.body == body) groups_.push_back(&group);
    }
  }

  std::string_view name() const override { return "elastic"; }
  TermDeclaration declaration() const override { return {}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return integrate([&](const auto& batch) {
      const auto u0 = gather<Order>(batch, stage.q0.data());
      auto du = gather<Order>(batch, q.data());
      for (int a = 0; a < num_nodes; ++a) {
        for (int i = 0; i < 3; ++i) du[a][i] -= u0[a][i];
      }
      return [this, u0, du](const auto& dN, const Tensor3<Pack>& inverse_jacobian) {
        return energy_change(law_, displacement_gradient<Order>(u0, dN, inverse_jacobian),
                             displacement_gradient<Order>(du, dN, inverse_jacobian));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> /*z*/) const override {
    return integrate([&](const auto& batch) {
      return [this, u = gather<Order>(batch, q.data())](const auto& dN, const Tensor3<Pack>& inverse_jacobian) {
        return law_.psi(displacement_gradient<Order>(u, dN, inverse_jacobian));
      };
    });
  }

  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    for (const Group* group : groups_) {
      for (std::size_t b = 0; b < group->batches.size(); ++b) {
        const auto u = gather<Order>(group->batches[b], q.data());
        NodeValues<num_nodes> f{};
        for (int point = 0; point < group->rule.size(); ++point) {
          const std::size_t at = group->geometry(b, point);
          const auto& dN = group->gradients(point);
          const Tensor3<Pack> H = displacement_gradient<Order>(u, dN, group->inverse_jacobian[at]);
          const Pack weight = group->rule.weights[point] * group->jacobian[at];
          const Tensor3<Pack> S = weight * pulled_back(law_.P(H), group->inverse_jacobian[at]);
          for (int a = 0; a < num_nodes; ++a) {
            for (int i = 0; i < 3; ++i) f[a][i] += S(i, 0) * dN[a][0] + S(i, 1) * dN[a][1] + S(i, 2) * dN[a][2];
          }
        }
        scatter_add<Order>(group->batches[b], f, r.data());
      }
    }
  }

  void add_hessian(const LocalStage&, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    CellMatrix<num_nodes> matrix;
    for (const Group* group : groups_) {
      for (std::size_t b = 0; b < group->batches.size(); ++b) {
        const auto u = gather<Order>(group->batches[b], q.data());
        matrix = {};
        for (int point = 0; point < group->rule.size(); ++point) {
          const std::size_t at = group->geometry(b, point);
          const auto& dN = group->gradients(point);
          const Tensor3<Pack> H = displacement_gradient<Order>(u, dN, group->inverse_jacobian[at]);
          const Pack weight = group->rule.weights[point] * group->jacobian[at];
          Tangent<Pack> A = tangent(law_, H);
          if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A);
          for (Pack& entry : A) entry *= weight;
          add_blocks<num_nodes>(pulled_back(A, group->inverse_jacobian[at]), dN, matrix);
        }
        scatter_add(*group, b, num_owned_nodes_, matrix, K);
      }
    }
  }

  double max_step(std::span<const double> q, std::span<const double> d) const override {
    double step = std::numeric_limits<double>::infinity();
    if constexpr (Law::needs_positive_volume) {
      for (const Group* group : groups_) {
        for (std::size_t b = 0; b < group->batches.size(); ++b) {
          const auto u = gather<Order>(group->batches[b], q.data());
          const auto du = gather<Order>(group->batches[b], d.data());
          for (int point = 0; point < group->rule.size(); ++point) {
            const auto& inverse = group->inverse_jacobian[group->geometry(b, point)];
            const auto F = add_to_diagonal(displacement_gradient<Order>(u, group->gradients(point), inverse), 1.0);
            const auto dF = displacement_gradient<Order>(du, group->gradients(point), inverse);
            if (!may_invert(F, dF)) continue;
            for (int lane = 0; lane < group->batches[b].num_lanes; ++lane) {
              step = std::min(step, first_inversion(one_lane(F, lane), one_lane(dF, lane)));
            }
          }
        }
      }
    }
    return step;
  }

  void stresses(std::span<const double> q,
                const std::function<void(PetscInt, const CellStress&)>& visit) const override {
    const auto centroid = Tet<Order>::gradients({0.25, 0.25, 0.25});
    for (const Group* group : groups_) {
      for (std::size_t b = 0; b < group->batches.size(); ++b) {
        const auto& batch = group->batches[b];
        const auto u = gather<Order>(batch, q.data());
        const Tensor3<Pack> H = displacement_gradient<Order>(u, centroid, group->centroid_inverse_jacobian[b]);
        const Pack psi = law_.psi(H);
        const Tensor3<Pack> P = law_.P(H), F = add_to_diagonal(H, 1.0);
        for (int lane = 0; lane < batch.num_lanes; ++lane) {
          if (batch.owned[lane] == 0.0) continue;
          visit(group->cells[b * pack_size + lane], cell_stress(one_lane(P, lane), one_lane(F, lane), psi[lane]));
        }
      }
    }
  }

 private:
  /// Compensated sum over the owned cells of weight * density; `density_of(batch)` gives the density as a function of
  /// the shape functions' gradients and dxi/dX at a point.
  template <class DensityOf>
  double integrate(DensityOf density_of) const {
    CompensatedSum<Pack> total;
    for (const Group* group : groups_) {
      for (std::size_t b = 0; b < group->batches.size(); ++b) {
        const auto density = density_of(group->batches[b]);
        const Pack& owned = group->batches[b].owned;
        for (int point = 0; point < group->rule.size(); ++point) {
          const std::size_t at = group->geometry(b, point);
          const Pack weight = group->rule.weights[point] * group->jacobian[at];
          const Pack contribution = weight * density(group->gradients(point), group->inverse_jacobian[at]);
          total.add(select(owned > 0.0, contribution, Pack(0.0)));  // a ghost's +inf times 0 would be NaN
        }
      }
    }
    const double result = sum(total.total());
    return std::isnan(result) ? std::numeric_limits<double>::infinity() : result;
  }

  static Tensor3<double> one_lane(const Tensor3<Pack>& A, int lane) {
    return make_tensor([&](int i, int j) -> double { return A(i, j)[lane]; });
  }

  static CellStress cell_stress(const Tensor3<double>& P, const Tensor3<double>& F, double psi) {
    const double J = det(F);
    const Tensor3<double> sigma = (1.0 / J) * matmul(P, transpose(F));
    const double pressure = trace(sigma) / 3.0;
    const Tensor3<double> s = add_to_diagonal(sigma, -pressure);
    return {{sigma(0, 0), sigma(1, 1), sigma(2, 2), sigma(0, 1), sigma(1, 2), sigma(0, 2)},
            std::sqrt(1.5 * dot(s, s)),
            J,
            psi};
  }

  Law law_;
  std::vector<const Group*> groups_;
  PetscInt num_owned_nodes_;
};

}  // namespace

template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(const ElasticLawVariant& law, const CellGroups<Order>& groups, int body,
                                               PetscInt num_owned_nodes) {
  return std::visit(
      [&](const auto& of) -> std::unique_ptr<ElasticTerm> {
        return std::make_unique<ElasticTermOf<Order, std::decay_t<decltype(of)>>>(of, groups, body, num_owned_nodes);
      },
      law);
}

template std::unique_ptr<ElasticTerm> make_elastic_term<1>(const ElasticLawVariant&, const CellGroups<1>&, int,
                                                           PetscInt);
template std::unique_ptr<ElasticTerm> make_elastic_term<2>(const ElasticLawVariant&, const CellGroups<2>&, int,
                                                           PetscInt);

int elastic_quadrature_degree(const ElasticLawVariant& law, int order) {
  // H is a polynomial of degree order - 1; St Venant-Kirchhoff's psi is one of degree 4 of H.
  return (order - 1) * (std::holds_alternative<SaintVenantKirchhoff>(law) ? 4 : 2);
}

}  // namespace pliant
