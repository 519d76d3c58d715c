#include "energy/viscous.hpp"

#include "energy/body_cells.hpp"
#include "material/kinematics.hpp"
#include "material/projection.hpp"
#include "material/saint_venant_kirchhoff.hpp"

#include <cassert>

namespace pliant {
namespace {

struct Dashpot {
  std::string_view name;      ///< of the law
  IsotropicTensor viscosity;  ///< eta [Pa s]
  double relaxation_time;     ///< tau [s]

  /// eta / (tau + dt) [Pa].
  IsotropicTensor stiffness(double dt) const { return 1.0 / (relaxation_time + dt) * viscosity; }
};

/// A symmetric tensor per point, xx yy zz xy yz xz.
constexpr int num_components = 6;
constexpr std::array<int, num_components> rows{0, 1, 2, 0, 1, 0}, columns{0, 1, 2, 1, 2, 2};

template <int Order>
std::size_t first_component(const CellPoint<Order>& point, int lane) {
  return num_components * (point.in.cell(lane) * point.in.group.rule.size() + point.number);
}

template <int Order>
PLIANT_INLINE Tensor3<Pack> load(const CellPoint<Order>& point, std::span<const double> z) {
  Tensor3<Pack> G;
  for (int lane = 0; lane < pack_size; ++lane) {
    const double* p = z.data() + first_component(point, lane);
    for (int k = 0; k < num_components; ++k) {
      G(rows[k], columns[k])[lane] = p[k];
      G(columns[k], rows[k])[lane] = p[k];
    }
  }
  return G;
}

template <int Order>
PLIANT_INLINE void store(const CellPoint<Order>& point, const Tensor3<Pack>& G, std::span<double> z) {
  for (int lane = 0; lane < point.in.batch().num_lanes; ++lane) {
    double* p = z.data() + first_component(point, lane);
    for (int k = 0; k < num_components; ++k) p[k] = G(rows[k], columns[k])[lane];
  }
}

/// What the strain E of the stage is compared with.
enum class Reference {
  start,     ///< E(q0)
  internal,  ///< G0
  rate       ///< none: sym(F^T (F - F0)) takes the place of the difference
};

template <int Order, Reference reference>
class ViscousTerm final : public EnergyTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ViscousTerm(const Dashpot& dashpot, const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes)
      : dashpot_(dashpot), cells_(groups, body, num_owned_nodes) {}

  std::string_view name() const override { return dashpot_.name; }
  TermDeclaration declaration() const override {
    return {.is_potential = reference != Reference::rate, .dissipates = true};
  }

  /// 1/2 D:C:D - 1/2 D0:C:D0 = (D - D0):C:(D + D0)/2 with D0 = D at q0.
  double value(const LocalStage& stage, std::span<const double> q) const override {
    if constexpr (reference == Reference::rate) return 0.0;
    const IsotropicTensor C = dashpot_.stiffness(stage.dt);
    return integrate(stage, q, [C](const Increment& d) { return dot(d.D_change, C(d.D - 0.5 * d.D_change)); });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const IsotropicTensor C = dashpot_.stiffness(stage.dt);
    const auto stress_of = [&](const Batch& batch) {
      return [C, increment = increments(stage, q, batch)](const Point& point) {
        const Increment d = increment(point);
        return matmul(d.F, C(d.D));  // P = F S
      };
    };
    cells_.add_forces(stress_of, r);
  }

  /// dP = dF S + F C:sym(F^T dF) is Saint Venant-Kirchhoff's. The rate's is dF S + F C:sym((F + dF0)^T dF), dF0 = F -
  /// F0, without symmetry; with F + dF0/2 on both sides of C it is symmetric and differs in the first order of dF0 by a
  /// skew part alone.
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const IsotropicTensor C = dashpot_.stiffness(stage.dt);
    const auto tangent_of = [&](const Batch& batch) {
      return [C, projection, increment = increments(stage, q, batch)](const Point& point) {
        const Increment d = increment(point);
        Tensor3<Pack> S = C(d.D), F = d.F;
        if constexpr (reference == Reference::rate) F = F + 0.5 * d.F_change;
        // The part F C F is semidefinite as it stands.
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(S);
        return SaintVenantKirchhoff<double>::Linearization<Pack>{C.shear, C.lambda(), F, S, {}}.tangent();
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  std::size_t num_internal() const override {
    return reference == Reference::internal ? num_components * cells_.num_points() : 0;
  }

  void end_stage(const LocalStage& stage, std::span<const double> q, std::span<double> z) const override {
    if constexpr (reference == Reference::internal) {
      const double share = stage.dt / (dashpot_.relaxation_time + stage.dt);
      cells_.for_each_batch([&](const Batch& batch) {
        const auto increment = increments(stage, q, batch);
        for_each_point(
            batch, [&](const Point& point) { store(point, load(point, stage.z0) + share * increment(point).D, z); });
      });
    }
  }

  void complete_step(std::span<const double> q, std::span<double> z) const override {
    if (reference != Reference::internal || dashpot_.relaxation_time > 0.0) return;
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      for_each_point(batch, [&](const Point& point) { store(point, green_lagrange(point.gradient(u)), z); });
    });
  }

  /// 1/2 (E - G):eta/tau:(E - G), in the spring.
  double energy(std::span<const double> q, std::span<const double> z) const override {
    if (reference != Reference::internal || dashpot_.relaxation_time == 0.0) return 0.0;
    const IsotropicTensor C = dashpot_.stiffness(0.0);
    return cells_.integrate([&](const Batch& batch) {
      return [C, z, u = batch.values(q)](const Point& point) {
        const Tensor3<Pack> D = green_lagrange(point.gradient(u)) - load(point, z);
        return 0.5 * dot(D, C(D));
      };
    });
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    const IsotropicTensor C = 1.0 / (dashpot_.relaxation_time + stage.dt) * dashpot_.stiffness(stage.dt);
    return integrate(stage, q, [C](const Increment& d) { return dot(d.D, C(d.D)); });
  }

 private:
  /// The stage at a point. D = E - G0, or what stands for it; D_change = D - D at q0, summed from dH: no digits of a
  /// stiff body's small strains cancel.
  struct Increment {
    Tensor3<Pack> F, F_change, D, D_change;
  };

  /// Increments of a batch as a function of the point.
  PLIANT_INLINE static auto increments(const LocalStage& stage, std::span<const double> q, const Batch& batch) {
    assert(reference != Reference::internal || !stage.z0.empty());
    return [z0 = stage.z0, u0 = batch.values(stage.q0), du = batch.change(q, stage.q0)](const Point& point) {
      const Tensor3<Pack> H0 = point.gradient(u0), dH = point.gradient(du);
      Increment d;
      d.F = add_to_diagonal(H0 + dH, 1.0);
      d.F_change = dH;
      if constexpr (reference == Reference::rate) {
        d.D_change = small_strain(matmul(transpose(d.F), dH));
      } else {
        d.D_change = green_lagrange_change(H0, dH);
      }
      d.D = d.D_change;
      if constexpr (reference == Reference::internal) d.D = d.D + (green_lagrange(H0) - load(point, z0));
      return d;
    };
  }

  template <class Density>
  double integrate(const LocalStage& stage, std::span<const double> q, Density density) const {
    return cells_.integrate([&](const Batch& batch) {
      return
          [density, increment = increments(stage, q, batch)](const Point& point) { return density(increment(point)); };
    });
  }

  template <class Visit>
  static void for_each_point(const Batch& batch, Visit visit) {
    for (int k = 0; k < batch.group.rule.size(); ++k) visit(Point{batch, k});
  }

  Dashpot dashpot_;
  BodyCells<Order> cells_;
};

}  // namespace

template <int Order>
std::unique_ptr<EnergyTerm> make_viscous_term(const ViscosityVariant& law, const CellGroups<Order>& groups, int body,
                                              PetscInt num_owned_nodes) {
  const auto make = [&]<Reference reference>(const Dashpot& dashpot) -> std::unique_ptr<EnergyTerm> {
    return std::make_unique<ViscousTerm<Order, reference>>(dashpot, groups, body, num_owned_nodes);
  };
  if (const auto* maxwell = std::get_if<Maxwell>(&law)) {
    const double tau = maxwell->relaxation_time;
    return make.template operator()<Reference::internal>(
        {Maxwell::name, tau * IsotropicTensor{maxwell->shear_modulus, maxwell->bulk_modulus}, tau});
  }
  const auto& kelvin_voigt = std::get<KelvinVoigt>(law);
  const Dashpot dashpot{KelvinVoigt::name, {kelvin_voigt.shear, kelvin_voigt.bulk}, 0.0};
  switch (kelvin_voigt.rate) {
    case StrainRate::secant:
      return make.template operator()<Reference::start>(dashpot);
    case StrainRate::reconstructed:
      return make.template operator()<Reference::internal>(dashpot);
    case StrainRate::exact:
      break;
  }
  return make.template operator()<Reference::rate>(dashpot);
}

template std::unique_ptr<EnergyTerm> make_viscous_term<1>(const ViscosityVariant&, const CellGroups<1>&, int, PetscInt);
template std::unique_ptr<EnergyTerm> make_viscous_term<2>(const ViscosityVariant&, const CellGroups<2>&, int, PetscInt);

StrainRate strain_rate_for(const Method& method) {
  if (method.order == 1) return StrainRate::secant;
  return keeps_order_with_reconstructed_rates(method) ? StrainRate::reconstructed : StrainRate::exact;
}

}  // namespace pliant
