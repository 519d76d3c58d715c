#include "energy/volume/mullins.hpp"

#include "energy/volume/branch_law.hpp"
#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/point_tensor.hpp"
#include "material/projection.hpp"

#include <utility>

namespace pliant {
namespace {

template <int Order>
class MullinsTerm final : public StressTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  MullinsTerm(const Mullins& softening, std::shared_ptr<const LawField> distortion, BodyCells<Order> cells)
      : softening_(softening), distortion_(std::move(distortion)), cells_(std::move(cells)) {}

  std::string_view name() const override { return "mullins"; }
  TermDeclaration declaration() const override { return {.dissipates = true, .dissipates_by_state = true}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, &stage, u0 = batch.values(stage.reference()),
              du = batch.change(q, stage.reference())](const Point& point) {
        const Tensor3<Pack> H0 = point.gradient(u0);
        const Pack W = distortion_->psi(point.index(), H0);
        const Pack dW = distortion_->psi_change(point.index(), H0, point.gradient(du));
        return softening_.withheld_change(W, dW, largest(point, stage.accepted_z));
      };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const auto stress_of = [&](const Batch& batch) {
      return [this, &stage, u = batch.values(q)](const Point& point) {
        return stress(point, point.gradient(u), largest(point, stage.accepted_z));
      };
    };
    cells_.add_forces(stress_of, r);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto tangent_of = [&](const Batch& batch) {
      return [this, &stage, projection, u = batch.values(q)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u), P = distortion_->P(point.index(), H);
        const Pack W = distortion_->psi(point.index(), H), Wm = largest(point, stage.accepted_z);
        const Pack change = softening_.eta_change(W, Wm), slope = softening_.eta_slope(W, Wm);
        Tangent<Pack> A;
        distortion_->tangent(point.index(), H, A);
        for (std::size_t p = 0; p < 9; ++p) {
          const Pack there = slope * P.a[p];
          for (std::size_t k = 0; k < 9; ++k) A[9 * p + k] = change * A[9 * p + k] + there * P.a[k];
        }
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A, H);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  std::size_t num_internal() const override { return cells_.num_points(); }
  int internal_components() const override { return 1; }
  void place_internal(std::span<InternalPlace> places) const override { place_points(cells_, 0, places); }

  void end_stage(const LocalStage& stage, std::span<const double> q, std::span<double> z) const override {
    complete_step(stage.accepted_z, q, z);
  }

  void complete_step(std::span<const double> accepted_z, std::span<const double> q,
                     std::span<double> z) const override {
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const Pack W = distortion_->psi(point.index(), point.gradient(u)), Wm = largest(point, accepted_z);
        store_number(point, select(W > Wm, W, Wm), z);
      }
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override {
    return cells_.integrate([&](const Batch& batch) {
      return [this, z, u = batch.values(q)](const Point& point) {
        return stored(point, point.gradient(u), largest(point, z));
      };
    });
  }

  double dissipated(std::span<const double> z) const override {
    return cells_.integrate([&](const Batch&) {
      return [this, z](const Point& point) { return softening_.dissipated(largest(point, z)); };
    });
  }

  StressPart part() const override { return StressPart::elastic; }

  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const auto at_points = [&](const Batch& batch) {
      return [&, u = batch.values(state.q)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u);
        const Pack Wm = largest(point, state.z);
        const Pack change = softening_.eta_change(distortion_->psi(point.index(), H), Wm);
        return PointStress{pulled_back_stress(H, stress(point, H, Wm)), stored(point, H, Wm), -change};
      };
    };
    visit_mean_stresses(cells_, state, StressMeasure::second_piola_kirchhoff, at_points, visit);
  }

 private:
  /// Wm; 0 at the start.
  static Pack largest(const Point& point, std::span<const double> z) {
    return z.empty() ? Pack(0.0) : load_number(point, z);
  }
  /// (eta - 1) dW/dF.
  Tensor3<Pack> stress(const Point& point, const Tensor3<Pack>& H, const Pack& Wm) const {
    const Pack W = distortion_->psi(point.index(), H);
    return softening_.eta_change(W, Wm) * distortion_->P(point.index(), H);
  }
  Pack stored(const Point& point, const Tensor3<Pack>& H, const Pack& Wm) const {
    return softening_.withheld(distortion_->psi(point.index(), H), Wm) - softening_.dissipated(Wm);
  }

  Mullins softening_;
  std::shared_ptr<const LawField> distortion_;
  BodyCells<Order> cells_;
};

}  // namespace

template <int Order>
std::unique_ptr<StressTerm> make_mullins_term(const Mullins& softening, std::shared_ptr<const LawField> distortion,
                                              const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes) {
  return std::make_unique<MullinsTerm<Order>>(softening, std::move(distortion),
                                              BodyCells<Order>(groups, body, num_owned_nodes));
}

template std::unique_ptr<StressTerm> make_mullins_term<1>(const Mullins&, std::shared_ptr<const LawField>,
                                                          const CellGroups<1>&, int, PetscInt);
template std::unique_ptr<StressTerm> make_mullins_term<2>(const Mullins&, std::shared_ptr<const LawField>,
                                                          const CellGroups<2>&, int, PetscInt);

}  // namespace pliant
