#include "energy/elastic.hpp"

#include "energy/body_cells.hpp"
#include "energy/energy_change.hpp"
#include "energy/step_bound.hpp"
#include "material/projection.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

template <int Order, class Law>
class ElasticTermOf final : public ElasticTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ElasticTermOf(const Law& law, const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes)
      : law_(law), cells_(groups, body, num_owned_nodes) {}

  std::string_view name() const override { return "elastic"; }
  TermDeclaration declaration() const override { return {}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, u0 = batch.values(stage.q0), du = batch.change(q, stage.q0)](const Point& point) {
        return energy_change(law_, point.gradient(u0), point.gradient(du));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> /*z*/) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, u = batch.values(q)](const Point& point) { return law_.psi(point.gradient(u)); };
    });
  }

  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    const auto stress_of = [&](const Batch& batch) {
      return [this, u = batch.values(q)](const Point& point) { return law_.P(point.gradient(u)); };
    };
    cells_.add_forces(stress_of, r);
  }

  void add_hessian(const LocalStage&, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto tangent_of = [&](const Batch& batch) {
      return [this, projection, u = batch.values(q)](const Point& point) {
        Tangent<Pack> A = tangent(law_, point.gradient(u));
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  double max_step(std::span<const double> q, std::span<const double> d) const override {
    double step = std::numeric_limits<double>::infinity();
    if constexpr (Law::needs_positive_volume) {
      cells_.for_each_batch([&](const Batch& batch) {
        const auto u = batch.values(q), du = batch.values(d);
        for (int k = 0; k < batch.group.rule.size(); ++k) {
          const Point point{batch, k};
          const Tensor3<Pack> F = add_to_diagonal(point.gradient(u), 1.0), dF = point.gradient(du);
          if (!may_invert(F, dF)) continue;
          for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
            step = std::min(step, first_inversion(one_lane(F, lane), one_lane(dF, lane)));
          }
        }
      });
    }
    return step;
  }

  void stresses(std::span<const double> q,
                const std::function<void(PetscInt, const CellStress&)>& visit) const override {
    const auto centroid = Tet<Order>::gradients({0.25, 0.25, 0.25});
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      const Tensor3<Pack> H =
          displacement_gradient<Order>(u, centroid, batch.group.centroid_inverse_jacobian[batch.number]);
      const Pack psi = law_.psi(H);
      const Tensor3<Pack> P = law_.P(H), F = add_to_diagonal(H, 1.0);
      for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
        if (batch.batch().owned[lane] == 0.0) continue;
        visit(batch.group.cells[batch.number * pack_size + lane],
              cell_stress(one_lane(P, lane), one_lane(F, lane), psi[lane]));
      }
    });
  }

 private:
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
  BodyCells<Order> cells_;
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
