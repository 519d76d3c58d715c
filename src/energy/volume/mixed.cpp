#include "energy/volume/mixed.hpp"

#include "base/limits.hpp"
#include "energy/volume/elastic_cells.hpp"
#include "material/kinematics.hpp"
#include "material/loading.hpp"
#include "material/projection.hpp"
#include "petsc/ghosted.hpp"

#include <vector>

namespace pliant {
namespace {

using Batch = CellBatch<2>;
using MixedPoint = CellPoint<2>;
using Lanes = PressureCoupling::Lanes;

/// The volume at a point: j = J - 1 (0 where J <= 0), and g of it.
struct VolumeState {
  Pack j;
  VolumeMeasure<Pack> measure;
  Pack::mask_type valid;

  VolumeState(VolumetricForm form, const Tensor3<Pack>& H) {
    const Pack change = volume_change(H);
    valid = change > -1.0;
    j = select(valid, change, Pack(0.0));
    measure = volume_measure(form, j);
  }
};

/// The largest shear modulus in the planes along the axes, of a body at rest [Pa].
double stiffness_against_shear(const ElasticLawSpec& law) {
  const Tangent<double> A = tangent_at_rest(law);
  double largest = 0.0;
  for (std::size_t p = 0; p < 9; ++p) {
    if (p % 4 != 0) largest = std::max(largest, A[9 * p + p]);
  }
  return largest;
}

class MixedTermOf final : public MixedTerm {
 public:
  MixedTermOf(const VolumeSplit& law, const CellGroups<2>& groups, int body, PetscInt num_owned_nodes,
              const PressureField& pressures)
      : law_(make_law_field(law.rest)),
        compliance_(1.0 / law.kappa),
        form_(law.form),
        shear_modulus_(stiffness_against_shear(law.rest)),
        cells_(groups, body, num_owned_nodes),
        pressures_(pressures) {
    const auto& of_node = pressures.layout().of_node[static_cast<std::size_t>(body)];
    cells_.for_each_batch([&](const Batch& batch) {
      auto& numbers = numbers_.emplace_back();
      for (int a = 0; a < 4; ++a) {
        for (int lane = 0; lane < pack_size; ++lane) numbers[a][lane] = of_node[batch.batch().nodes[a][lane]];
      }
    });
  }

  std::string_view name() const override { return "elastic with pressure"; }
  TermDeclaration declaration() const override { return {.is_potential = false}; }

  /// At the present pressures.
  double value(const LocalStage& stage, std::span<const double> q) const override {
    const ConstGhostedView p(pressures_.values());
    return integrate([&](const Batch& batch, std::size_t number) {
      return [this, u0 = batch.values(stage.reference()), du = batch.change(q, stage.reference()),
              p = gather_pressures(p.span(), number)](const MixedPoint& point) {
        const Tensor3<Pack> H0 = point.gradient(u0), dH = point.gradient(du);
        const VolumeState before(form_, H0), after(form_, H0 + dH);
        const Pack change =
            law_->psi_change(point.index(), H0, dH) + pressure_at(point, p) * (after.measure.g - before.measure.g);
        return select(before.valid && after.valid, change, Pack(infinity));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> /*z*/) const override {
    const ConstGhostedView p(pressures_.values());
    return integrate([&](const Batch& batch, std::size_t number) {
      return [this, u = batch.values(q), p = gather_pressures(p.span(), number)](const MixedPoint& point) {
        return density(point.index(), point.gradient(u), pressure_at(point, p));
      };
    });
  }

  void add_gradient(const LocalStage&, std::span<const double> q, std::span<double> r) const override {
    const ConstGhostedView p(pressures_.values());
    std::size_t number = 0;
    const auto stress_of = [&](const Batch& batch) {
      return [this, u = batch.values(q), p = gather_pressures(p.span(), number++)](const MixedPoint& point) {
        return stress(point.index(), point.gradient(u), pressure_at(point, p));
      };
    };
    cells_.add_forces(stress_of, r);
  }

  void add_hessian(const LocalStage&, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const ConstGhostedView p(pressures_.values());
    std::size_t number = 0;
    const auto tangent_of = [&](const Batch& batch) {
      return
          [this, projection, u = batch.values(q), p = gather_pressures(p.span(), number++)](const MixedPoint& point) {
            const Tensor3<Pack> H = point.gradient(u), F = add_to_diagonal(H, 1.0);
            Tangent<Pack> A;
            law_->tangent(point.index(), H, A);
            // p (g'' cof F (x) cof F + g' d cof F/dF), the latter eps_ikm eps_JLN F_mN
            const VolumeState volume(form_, H);
            const Pack at = select(volume.valid, pressure_at(point, p), Pack(nan));
            const Pack curvature = at * volume.measure.curvature, slope = at * volume.measure.slope;
            const Tensor3<Pack> C = cofactor(F);
            for (int i = 0; i < 3; ++i) {
              for (int J = 0; J < 3; ++J) {
                for (int k = 0; k < 3; ++k) {
                  for (int L = 0; L < 3; ++L) {
                    Pack& entry = A[9 * (3 * i + J) + 3 * k + L];
                    entry += curvature * (C(i, J) * C(k, L));
                    if (i == k || J == L) continue;
                    const double sign = ((k - i + 3) % 3 == 1) == ((L - J + 3) % 3 == 1) ? 1.0 : -1.0;
                    entry += sign * slope * F(3 - i - k, 3 - J - L);
                  }
                }
              }
            }
            if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A);
            return A;
          };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  double max_step(const LocalStage& /*stage*/, std::span<const double> q, std::span<const double> d) const override {
    return step_to_inversion(cells_, q, d);
  }

  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const ConstGhostedView values(pressures_.values());
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const Tensor3<Pack> H = centroid_gradient(batch, batch.values(state.q));
      const std::size_t n = MixedPoint{batch, 0}.index();
      const auto p = gather_pressures(values.span(), number);
      const Pack mean = 0.25 * ((p[0] + p[1]) + (p[2] + p[3]));
      visit_stresses(batch, {H, stress(n, H, mean), det(add_to_diagonal(H, 1.0)), density(n, H, mean)}, visit);
    });
  }

  void add_pressure_gradient(std::span<const double> q, std::span<double> r) const override {
    const ConstGhostedView values(pressures_.values());
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const auto u = batch.values(q);
      const auto p = gather_pressures(values.span(), number);
      std::array<Pack, 4> f{};
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const MixedPoint point{batch, k};
        const VolumeState volume(form_, point.gradient(u));
        const Pack residual = point.weight() * (volume.measure.g - compliance_ * pressure_at(point, p));
        const auto N = shape_values(point);
        for (int b = 0; b < 4; ++b) f[b] += N[b] * select(volume.valid, residual, Pack(nan));
      }
      scatter(batch, number, f, r);
    });
  }

  void add_pressure_volumes(std::span<double> m) const override {
    for_each_batch([&](const Batch& batch, std::size_t number) {
      std::array<Pack, 4> f{};
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const MixedPoint point{batch, k};
        const auto N = shape_values(point);
        for (int b = 0; b < 4; ++b) f[b] += N[b] * point.weight();
      }
      scatter(batch, number, f, m);
    });
  }

  void couple(std::span<const double> q, const std::function<void(const PressureCoupling&)>& visit) const override {
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const auto u = batch.values(q);
      std::array<std::array<Pack, 4>, 3 * CellGroup<2>::num_nodes> B{};
      std::array<std::array<Pack, 4>, 4> C{};
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const MixedPoint point{batch, k};
        const auto N = shape_values(point);
        const auto& dN = point.shape_gradients();
        const Pack weight = point.weight();
        const Tensor3<Pack> H = point.gradient(u);
        const VolumeState volume(form_, H);
        const Pack slope = select(volume.valid, volume.measure.slope, Pack(nan));
        const Tensor3<Pack> S =
            Pack(weight * slope) * pulled_back(cofactor(add_to_diagonal(H, 1.0)), point.inverse_jacobian());
        for (int a = 0; a < CellGroup<2>::num_nodes; ++a) {
          for (int i = 0; i < 3; ++i) {
            const Pack s = S(i, 0) * dN[a][0] + S(i, 1) * dN[a][1] + S(i, 2) * dN[a][2];
            for (int b = 0; b < 4; ++b) B[3 * a + i][b] += N[b] * s;
          }
        }
        for (int b = 0; b < 4; ++b) {
          for (int c = 0; c < 4; ++c) C[b][c] += compliance_ * N[b] * N[c] * weight;
        }
      }
      visit({batch.batch().num_lanes, batch.batch().nodes, numbers_[number], B, C});
    });
  }

  double shear_modulus() const override { return shear_modulus_; }

 private:
  using Pressures = std::array<Pack, 4>;

  static std::array<double, 4> shape_values(const MixedPoint& point) {
    return Tet<1>::values(point.in.group.rule.points[point.number]);
  }
  static Pack pressure_at(const MixedPoint& point, const Pressures& p) {
    const auto N = shape_values(point);
    return (N[0] * p[0] + N[1] * p[1]) + (N[2] * p[2] + N[3] * p[3]);
  }

  Pressures gather_pressures(std::span<const double> local, std::size_t number) const {
    Pressures p;
    for (int a = 0; a < 4; ++a) p[a] = Pack([&](auto lane) { return local[numbers_[number][a][lane]]; });
    return p;
  }
  void scatter(const Batch& batch, std::size_t number, const Pressures& f, std::span<double> local) const {
    for (int a = 0; a < 4; ++a) {
      for (int lane = 0; lane < batch.batch().num_lanes; ++lane) local[numbers_[number][a][lane]] += f[a][lane];
    }
  }

  Tensor3<Pack> stress(std::size_t n, const Tensor3<Pack>& H, const Pack& p) const {
    const VolumeState volume(form_, H);
    const Pack slope = select(volume.valid, p * volume.measure.slope, Pack(nan));
    return law_->P(n, H) + slope * cofactor(add_to_diagonal(H, 1.0));
  }
  Pack density(std::size_t n, const Tensor3<Pack>& H, const Pack& p) const {
    const VolumeState volume(form_, H);
    const Pack value = law_->psi(n, H) + p * (volume.measure.g - 0.5 * compliance_ * p);
    return select(volume.valid, value, Pack(infinity));
  }

  /// `visit(batch, number)`, in the order of BodyCells.
  template <class Visit>
  void for_each_batch(const Visit& visit) const {
    std::size_t number = 0;
    cells_.for_each_batch([&](const Batch& batch) { visit(batch, number++); });
  }
  template <class DensityOf>
  double integrate(const DensityOf& density_of) const {
    std::size_t number = 0;
    return cells_.integrate([&](const Batch& batch) { return density_of(batch, number++); });
  }

  std::unique_ptr<LawField> law_;
  double compliance_;  // 1 / kappa
  VolumetricForm form_;
  double shear_modulus_;
  BodyCells<2> cells_;
  const PressureField& pressures_;
  std::vector<std::array<Lanes, 4>> numbers_;  // local pressures of each batch
};

}  // namespace

std::unique_ptr<MixedTerm> make_mixed_term(const VolumeSplit& law, const CellGroups<2>& groups, int body,
                                           PetscInt num_owned_nodes, const PressureField& pressures) {
  return std::make_unique<MixedTermOf>(law, groups, body, num_owned_nodes, pressures);
}

}  // namespace pliant
