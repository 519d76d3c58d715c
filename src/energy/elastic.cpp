#include "energy/elastic.hpp"

#include "energy/active_strain.hpp"
#include "energy/body_cells.hpp"
#include "energy/step_bound.hpp"
#include "material/projection.hpp"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

template <int Order>
class ElasticTermOf final : public ElasticTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ElasticTermOf(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups, int body,
                PetscInt num_owned_nodes, std::shared_ptr<const Activation> shortening)
      : law_(std::move(law)), shortening_(std::move(shortening)), cells_(groups, body, num_owned_nodes) {}

  std::string_view name() const override { return "elastic"; }
  TermDeclaration declaration() const override { return {.depends_on_time = shortening_ != nullptr}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    const LawNow law = law_at(instant_of(stage));
    return cells_.integrate([&](const Batch& batch) {
      return [&law, u0 = batch.values(stage.q0), du = batch.change(q, stage.q0)](const Point& point) {
        return law->psi_change(point.index(), point.gradient(u0), point.gradient(du));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const override {
    const LawNow law = law_at(at);
    return cells_.integrate([&](const Batch& batch) {
      return [&law, u = batch.values(q)](const Point& point) { return law->psi(point.index(), point.gradient(u)); };
    });
  }

  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!shortening_) return 0.0;
    const ActiveStrain law(*law_, *shortening_, instant_of(stage));
    const PerPoint<Pack> rate = shortening_->rates(stage);
    return cells_.integrate([&](const Batch& batch) {
      return [&law, &rate, u = batch.values(q)](const Point& point) {
        return rate[point.index()] * law.slope(point.index(), point.gradient(u));
      };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const LawNow law = law_at(instant_of(stage));
    const auto stress_of = [&](const Batch& batch) {
      return [&law, u = batch.values(q)](const Point& point) { return law->P(point.index(), point.gradient(u)); };
    };
    cells_.add_forces(stress_of, r);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const LawNow law = law_at(instant_of(stage));
    const auto tangent_of = [&](const Batch& batch) {
      return [&law, projection, u = batch.values(q)](const Point& point) {
        Tangent<Pack> A;
        law->tangent(point.index(), point.gradient(u), A);
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  double max_step(std::span<const double> q, std::span<const double> d) const override {
    double step = std::numeric_limits<double>::infinity();
    if (!law_->traits().is_barrier) return step;
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
    return step;
  }

  void stresses(const Instant& at, std::span<const double> q,
                const std::function<void(PetscInt, const CellStress&)>& visit) const override {
    const LawNow law = law_at(at);
    const auto centroid = Tet<Order>::gradients({0.25, 0.25, 0.25});
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      const Tensor3<Pack> H =
          displacement_gradient<Order>(u, centroid, batch.group.centroid_inverse_jacobian[batch.number]);
      const std::size_t n = Point{batch, 0}.index();
      const Pack psi = law->psi(n, H);
      const Tensor3<Pack> P = law->P(n, H), F = add_to_diagonal(H, 1.0);
      for (int lane = 0; lane < batch.batch().num_lanes; ++lane) {
        if (batch.batch().owned[lane] == 0.0) continue;
        visit(batch.group.cells[batch.number * pack_size + lane],
              cell_stress(one_lane(P, lane), one_lane(F, lane), psi[lane]));
      }
    });
  }

 private:
  /// The law as it is at an instant: its own, or that of fibres that have shortened.
  class LawNow {
   public:
    explicit LawNow(const LawField& law) : law_(&law) {}
    explicit LawNow(std::unique_ptr<const LawField> own) : own_(std::move(own)), law_(own_.get()) {}
    const LawField* operator->() const { return law_; }

   private:
    std::unique_ptr<const LawField> own_;
    const LawField* law_;
  };
  LawNow law_at(const Instant& at) const {
    if (!shortening_) return LawNow(*law_);
    return LawNow(std::make_unique<ActiveStrain>(*law_, *shortening_, at));
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

  std::shared_ptr<const LawField> law_;
  std::shared_ptr<const Activation> shortening_;  // or nullptr
  BodyCells<Order> cells_;
};

}  // namespace

template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups,
                                               int body, PetscInt num_owned_nodes,
                                               std::shared_ptr<const Activation> shortening) {
  return std::make_unique<ElasticTermOf<Order>>(std::move(law), groups, body, num_owned_nodes, std::move(shortening));
}

template <int Order>
std::unique_ptr<LawField> make_varying_law(
    const ElasticLawSpec& common, const NodeLayout& layout, const CellGroups<Order>& groups, int body,
    const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>& at) {
  const std::vector<PackPlaces> places = places_of_points<Order>(layout, groups, body);
  return make_law_field(common, places.size(),
                        [&](std::size_t n, int lane) { return at(places[n].cell[lane], places[n].X[lane]); });
}

#define PLIANT_INSTANTIATE(Order)                                                                                   \
  template std::unique_ptr<ElasticTerm> make_elastic_term<Order>(                                                   \
      std::shared_ptr<const LawField>, const CellGroups<Order>&, int, PetscInt, std::shared_ptr<const Activation>); \
  template std::unique_ptr<LawField> make_varying_law<Order>(                                                       \
      const ElasticLawSpec&, const NodeLayout&, const CellGroups<Order>&, int,                                      \
      const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>&);
PLIANT_INSTANTIATE(1)
PLIANT_INSTANTIATE(2)
#undef PLIANT_INSTANTIATE

int elastic_quadrature_degree(const LawTraits& law, int order) {
  return (order - 1) * law.energy_degree;  // H is a polynomial of degree order - 1
}

}  // namespace pliant
