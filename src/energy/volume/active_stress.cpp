#include "energy/volume/active_stress.hpp"

#include "energy/volume/cell_stresses.hpp"
#include "material/fibre.hpp"

#include <utility>

namespace pliant {
namespace {

template <int Order>
class ActiveStress final : public StressTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ActiveStress(std::shared_ptr<const Activation> tension, const CellGroups<Order>& groups, int body,
               PetscInt num_owned_nodes)
      : tension_(std::move(tension)), cells_(groups, body, num_owned_nodes) {}

  std::string_view name() const override { return "active-stress"; }
  TermDeclaration declaration() const override { return {.account = Account::load}; }
  bool has_adjoint() const override { return true; }

  /// T/2 (I4 - I4 at q0) = T (F + dF/2) f . dF f, F at q0.
  double value(const LocalStage& stage, std::span<const double> q) const override {
    const PerPoint<Pack> T = tension_->amounts(instant_of(stage));
    return cells_.integrate([&](const Batch& batch) {
      return [this, &T, u0 = batch.values(stage.q0), du = batch.change(q, stage.q0)](const Point& point) {
        const auto& f = tension_->fibre(point.index());
        const Tensor3<Pack> dF = point.gradient(du);
        const Tensor3<Pack> middle = add_to_diagonal(point.gradient(u0) + 0.5 * dF, 1.0);
        return T[point.index()] * dot(matvec(middle, f), matvec(dF, f));
      };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const PerPoint<Pack> T = tension_->amounts(instant_of(stage));
    const auto stress_of = [&](const Batch& batch) {
      return [this, &T, u = batch.values(q)](const Point& point) {
        const auto& f = tension_->fibre(point.index());
        return T[point.index()] * outer(matvec(add_to_diagonal(point.gradient(u), 1.0), f), f);
      };
    };
    cells_.add_forces(stress_of, r);
  }

  /// dP = T (dF f) (x) f: semidefinite where T >= 0.
  void add_hessian(const LocalStage& stage, std::span<const double>, const BlockWriter& K,
                   Projection projection) const override {
    const PerPoint<Pack> T = tension_->amounts(instant_of(stage));
    const auto tangent_of = [&](const Batch&) {
      return [this, &T, projection](const Point& point) {
        const auto& f = tension_->fibre(point.index());
        Pack t = T[point.index()];
        if (projection == Projection::positive_semidefinite) t = select(t > 0.0, t, Pack(0.0));
        const Tensor3<Pack> ff = t * outer(f, f);
        Tangent<Pack> A{};
        for (int i = 0; i < 3; ++i) {
          for (int J = 0; J < 3; ++J) {
            for (int L = 0; L < 3; ++L) A[9 * (3 * i + J) + 3 * i + L] = ff(J, L);
          }
        }
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  StressPart part() const override { return StressPart::active; }

  /// Stores no energy: the work comes from outside of mechanics.
  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const PerPoint<Pack> T = tension_->amounts(state.at);
    const auto at_points = [&](const Batch&) {
      return [&](const Point& point) {
        const auto& f = tension_->fibre(point.index());
        return PointStress{T[point.index()] * outer(f, f), 0.0};
      };
    };
    visit_mean_stresses(cells_, state, StressMeasure::second_piola_kirchhoff, at_points, visit);
  }

 private:
  std::shared_ptr<const Activation> tension_;
  BodyCells<Order> cells_;
};

}  // namespace

template <int Order>
std::unique_ptr<EnergyTerm> make_active_stress_term(std::shared_ptr<const Activation> tension,
                                                    const CellGroups<Order>& groups, int body,
                                                    PetscInt num_owned_nodes) {
  return std::make_unique<ActiveStress<Order>>(std::move(tension), groups, body, num_owned_nodes);
}

template std::unique_ptr<EnergyTerm> make_active_stress_term<1>(std::shared_ptr<const Activation>, const CellGroups<1>&,
                                                                int, PetscInt);
template std::unique_ptr<EnergyTerm> make_active_stress_term<2>(std::shared_ptr<const Activation>, const CellGroups<2>&,
                                                                int, PetscInt);

}  // namespace pliant
