#include "energy/volume/prony.hpp"

#include "energy/volume/branch_law.hpp"
#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/point_tensor.hpp"
#include "material/projection.hpp"

namespace pliant {
namespace {

template <int Order>
class PronyTerm final : public StressTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  PronyTerm(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic, BodyCells<Order> cells,
            std::shared_ptr<const FreeExpansion> expansion)
      : branches_(std::move(branches)),
        elastic_(std::move(elastic)),
        branch_law_(*elastic_),
        cells_(std::move(cells)),
        expansion_(std::move(expansion)),
        num_per_branch_(num_symmetric * cells_.num_points()) {}

  std::string_view name() const override { return Prony::name; }
  TermDeclaration declaration() const override { return {.dissipates = true}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    const auto expanded = expanded_at(instant_of(stage));
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, &expanded, u0 = batch.values(stage.reference()),
              du = batch.change(q, stage.reference())](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H0 = at.strain(point.gradient(u0)), dH = at.inverse * point.gradient(du);
        return at.volume * (weight(stage.dt) * elastic_->psi_change(point.index(), H0, dH) -
                            dot(forgotten(stage, point), branch_law_.strain_change(H0, dH)));
      };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const auto expanded = expanded_at(instant_of(stage));
    cells_.add_forces(stresses_of(expanded, stage, q), r);
  }

  bool has_adjoint() const override { return true; }

  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override {
    const auto expanded = expanded_at(instant_of(stage));
    cells_.add_works(stresses_of(expanded, stage, q), d, works);
  }

  void pull_back(const LocalStage& stage, std::span<const double> q, const StageMultipliers& m,
                 const StageSlopes& slopes) const override {
    const auto expanded = expanded_at(instant_of(stage));
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q), l = batch.values(m.residual);
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = at.strain(point.gradient(u));
        const Tensor3<Pack> B =
            Pack(-point.weight() * at.volume * at.inverse) * branch_law_.pulled_back_force(H, point.gradient(l));
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          add_multiplier(point, Pack(weight(i, stage.dt)) * B, branch(i, slopes.z0));
        }
      }
    });
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      const double left = branches_[i].relaxation_time / (branches_[i].relaxation_time + stage.dt);
      const auto of_start = branch(i, slopes.z0);
      const auto of_end = branch(i, m.internal);
      for (std::size_t k = 0; k < of_start.size(); ++k) of_start[k] += left * of_end[k];
    }
    const auto slope_of = [&](const Batch& batch) {
      return [this, &stage, &m, &expanded, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        Tensor3<Pack> Z{};
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const double share = stage.dt / (branches_[i].relaxation_time + stage.dt);
          Z = Z + share * load_multiplier(point, branch(i, m.internal));
        }
        return at.inverse * branch_law_.stress_slope(point.index(), at.strain(point.gradient(u)), Z);
      };
    };
    cells_.add_slopes_of_points(slope_of, slopes.q);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto expanded = expanded_at(instant_of(stage));
    const auto tangent_of = [&](const Batch& batch) {
      return [this, &stage, &expanded, projection, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        Tangent<Pack> A;
        const Tensor3<Pack> H = at.strain(point.gradient(u));
        elastic_->tangent(point.index(), H, A);
        for (Pack& entry : A) entry *= weight(stage.dt);
        branch_law_.subtract_stiffness(H, forgotten(stage, point), A);
        const Pack scale = at.volume * at.inverse * at.inverse;
        for (Pack& entry : A) entry *= scale;
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A, H);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  std::size_t num_internal() const override { return branches_.size() * num_per_branch_; }

  void place_internal(std::span<InternalPlace> places) const override {
    const std::size_t num_points = cells_.num_points();
    for (std::size_t i = 0; i < branches_.size(); ++i) {
      place_points(cells_, static_cast<int>(i), places.subspan(i * num_points, num_points));
    }
  }

  void end_stage(const LocalStage& stage, std::span<const double> q, std::span<double> z) const override {
    const auto expanded = expanded_at(instant_of(stage));
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const Tensor3<Pack> S = branch_law_.stress(point.index(), expanded[point.index()].strain(point.gradient(u)));
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          store_symmetric(point, ended(i, stage, point, S), branch(i, z));
        }
      }
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& instant, std::span<const double> q, std::span<const double> z) const override {
    const auto expanded = expanded_at(instant);
    return cells_.integrate([&](const Batch& batch) {
      return [this, z, &expanded, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = at.strain(point.gradient(u));
        Pack total = 0.0;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = load_symmetric(point, branch(i, z));
          total += branches_[i].ratio * branch_law_.state(point.index(), H, A).energy;
        }
        return at.volume * total;
      };
    });
  }

  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!expansion_) return 0.0;
    const auto expanded = expanded_at(instant_of(stage));
    const PerPoint<Pack> rates = expansion_->stretch().rates(stage);
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, &expanded, &rates, u = batch.values(q)](const Point& point) {
        const std::size_t n = point.index();
        const ExpandedPoint& at = expanded[n];
        const Tensor3<Pack> H = at.strain(point.gradient(u)), P = elastic_->P(n, H), S = branch_law_.stress(n, H);
        Pack total = 0.0;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = ended(i, stage, point, S), P_i = P - branch_law_.force(H, A);
          total += branches_[i].ratio * at.power(rates[n], branch_law_.state(n, H, A).energy, P_i, H);
        }
        return total;
      };
    });
  }

  StressPart part() const override { return StressPart::viscous; }

  /// sum_i H_i, and what the branches store.
  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const bool is_small = branch_law_.strain_measure() == BranchLaw::Strain::small;
    const auto expanded = expanded_at(state.at);
    const auto at_points = [&](const Batch& batch) {
      return [&, u = batch.values(state.q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = at.strain(point.gradient(u)), P = elastic_->P(point.index(), H);
        PointStress total;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = load_symmetric(point, branch(i, state.z));
          const Tensor3<Pack> P_i = P - branch_law_.force(H, A);
          total.S = total.S + branches_[i].ratio * (is_small ? P_i : pulled_back_stress(H, P_i));
          total.energy += branches_[i].ratio * branch_law_.state(point.index(), H, A).energy;
        }
        total.S = Pack(at.volume * at.inverse * at.inverse) * total.S;
        total.energy *= at.volume;
        return total;
      };
    };
    visit_mean_stresses(cells_, state, is_small ? StressMeasure::small_strain : StressMeasure::second_piola_kirchhoff,
                        at_points, visit);
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    const auto expanded = expanded_at(instant_of(stage));
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, &expanded, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = at.strain(point.gradient(u)), S = branch_law_.stress(point.index(), H);
        Pack total = 0.0;
        for (std::size_t i = 0; i < branches_.size(); ++i) {
          const Tensor3<Pack> A = ended(i, stage, point, S);
          const BranchState state = branch_law_.state(point.index(), H, A);
          total += branches_[i].ratio / branches_[i].relaxation_time * dot(S - A, state.elongation);
        }
        return at.volume * total;
      };
    });
  }

 private:
  auto stresses_of(const PerPoint<ExpandedPoint>& expanded, const LocalStage& stage, std::span<const double> q) const {
    return [this, &expanded, &stage, q](const Batch& batch) {
      return [this, &stage, &expanded, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = at.strain(point.gradient(u));
        return Pack(at.volume * at.inverse) *
               (weight(stage.dt) * elastic_->P(point.index(), H) - branch_law_.force(H, forgotten(stage, point)));
      };
    };
  }
  PerPoint<ExpandedPoint> expanded_at(const Instant& instant) const {
    return expanded_points(expansion_.get(), instant, split_of(*elastic_));
  }
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
  template <class T>
  std::span<T> branch(std::size_t i, std::span<T> z) const {
    return z.subspan(i * num_per_branch_, num_per_branch_);
  }

  std::vector<Prony> branches_;
  std::shared_ptr<const LawField> elastic_;
  BranchLaw branch_law_;
  BodyCells<Order> cells_;
  std::shared_ptr<const FreeExpansion> expansion_;
  std::size_t num_per_branch_;  // internal variables
};

}  // namespace

template <int Order>
std::unique_ptr<EnergyTerm> make_prony_term(std::vector<Prony> branches, std::shared_ptr<const LawField> elastic,
                                            const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes,
                                            std::shared_ptr<const FreeExpansion> expansion) {
  return std::make_unique<PronyTerm<Order>>(std::move(branches), std::move(elastic),
                                            BodyCells<Order>(groups, body, num_owned_nodes), std::move(expansion));
}

template std::unique_ptr<EnergyTerm> make_prony_term<1>(std::vector<Prony>, std::shared_ptr<const LawField>,
                                                        const CellGroups<1>&, int, PetscInt,
                                                        std::shared_ptr<const FreeExpansion>);
template std::unique_ptr<EnergyTerm> make_prony_term<2>(std::vector<Prony>, std::shared_ptr<const LawField>,
                                                        const CellGroups<2>&, int, PetscInt,
                                                        std::shared_ptr<const FreeExpansion>);

}  // namespace pliant
