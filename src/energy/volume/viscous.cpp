#include "energy/volume/viscous.hpp"

#include "energy/volume/cell_stresses.hpp"
#include "energy/volume/point_tensor.hpp"
#include "material/kinematics.hpp"
#include "material/projection.hpp"
#include "material/saint_venant_kirchhoff.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace pliant {
namespace {

struct Dashpot {
  std::string_view name;                           ///< of the law
  std::vector<IsotropicTensor<Pack>> viscosities;  ///< eta [Pa s] of each pack of points, or one of all
  double relaxation_time;                          ///< tau [s]

  const IsotropicTensor<Pack>& viscosity(std::size_t n) const { return viscosities[viscosities.size() > 1 ? n : 0]; }
  /// eta / (tau + dt) [Pa].
  PLIANT_INLINE IsotropicTensor<Pack> stiffness(std::size_t n, double dt) const {
    return 1.0 / (relaxation_time + dt) * viscosity(n);
  }
};

/// C0 of an isotropic elastic law at its n-th pack of points [Pa].
IsotropicTensor<Pack> tangent_at_rest(const LawField& elastic, std::size_t n) {
  Tangent<Pack> A;
  elastic.tangent(n, Tensor3<Pack>{}, A);
  const Pack mu = A[9 * 1 + 1], lambda = A[9 * 0 + 4];  // A_1212, A_1122
  return {mu, lambda + 2.0 / 3.0 * mu};
}

/// The strain from which the strain E of the stage is measured.
enum class Reference {
  start,     ///< E(q0)
  internal,  ///< G0
  rate       ///< none: sym(F^T (F - F0)) replaces the difference
};

template <int Order, Reference reference>
class ViscousTerm final : public StressTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ViscousTerm(Dashpot dashpot, BodyCells<Order> cells, std::shared_ptr<const FreeExpansion> expansion)
      : dashpot_(std::move(dashpot)), cells_(std::move(cells)), expansion_(std::move(expansion)) {}

  std::string_view name() const override { return dashpot_.name; }
  TermDeclaration declaration() const override {
    return {.is_potential = (reference != Reference::rate), .dissipates = true};
  }

  /// s dE/dD (D:C:D - D0:C:D0)/2 = s dE/dD (D - D0):C:(D + D0)/2 with D0 = D at q0.
  double value(const LocalStage& stage, std::span<const double> q) const override {
    if constexpr (reference == Reference::rate) return 0.0;
    return integrate(stage, q, [&](const Increment& d) {
      return d.stress / d.slope * dot(d.D_change, dashpot_.stiffness(d.n, stage.dt)(d.D - 0.5 * d.D_change));
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const auto expanded = expanded_at(stage);
    cells_.add_forces(stresses_of(expanded, stage, q), r);
  }

  bool has_adjoint() const override { return true; }

  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override {
    const auto expanded = expanded_at(stage);
    cells_.add_works(stresses_of(expanded, stage, q), d, works);
  }

  /// P : L = S : sym(F^T L) changes by Y : dD with Y = C : sym(F^T L).
  void pull_back(const LocalStage& stage, std::span<const double> q, const StageMultipliers& m,
                 const StageSlopes& slopes) const override {
    const auto expanded = expanded_at(stage);
    const auto multiplier_of = [&](const Batch& batch) {
      return [this, dt = stage.dt, increment = increments(expanded, stage, q, batch),
              l = batch.values(m.residual)](const Point& point) {
        const Increment d = increment(point);
        return std::pair(d, multiplier(d, point.gradient(l), dt));
      };
    };
    if constexpr (reference == Reference::internal) {
      const bool has_spring = dashpot_.relaxation_time > 0.0;
      const double share = stage.dt / (dashpot_.relaxation_time + stage.dt);
      cells_.for_each_batch([&](const Batch& batch) {
        const auto multiplier_at = multiplier_of(batch);
        for_each_point(batch, [&](const Point& point) {
          const auto [d, Y] = multiplier_at(point);
          const Pack scale = has_spring ? Pack(1.0) : d.inverse2;
          add_multiplier(point, Pack(-point.weight() * scale) * Y, slopes.z0);
        });
      });
      for (std::size_t i = 0; i < slopes.z0.size(); ++i) slopes.z0[i] += (1.0 - share) * m.internal[i];
      const auto slope_of = [&](const Batch& batch) {
        return [share, has_spring, increment = increments(expanded, stage, q, batch), &m](const Point& point) {
          const Increment d = increment(point);
          return Pack(has_spring ? share * d.inverse2 : Pack(share)) * matmul(d.F, load_multiplier(point, m.internal));
        };
      };
      cells_.add_slopes_of_points(slope_of, slopes.q);
    } else {
      const auto slope_of = [&](const Batch& batch) {
        return [multiplier_at = multiplier_of(batch)](const Point& point) {
          const auto [d, Y] = multiplier_at(point);
          // E(q0), or F0 of sym(F^T (F - F0)).
          const Tensor3<Pack> F = reference == Reference::start ? d.F - d.F_change : d.F;
          return Pack(-d.inverse2) * matmul(F, Y);
        };
      };
      cells_.add_forces(slope_of, slopes.q0);
    }
  }

  void pull_back_completion(std::span<const double> q, std::span<double> z, std::span<double> r) const override {
    if (reference != Reference::internal || dashpot_.relaxation_time > 0.0) return;
    const auto slope_of = [&](const Batch& batch) {
      return [z, u = batch.values(q)](const Point& point) {
        return matmul(add_to_diagonal(point.gradient(u), 1.0), load_multiplier(point, z));
      };
    };
    cells_.add_slopes_of_points(slope_of, r);
    std::ranges::fill(z, 0.0);
  }

  /// The derivative of P : L by F is L S + (dF + (1 - 2 k dt) F) Y / s^2, dF = F - F0; add_hessian has another second
  /// part.
  void add_transposed_rest(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                           std::span<double> r) const override {
    if constexpr (reference != Reference::rate) return;
    const auto expanded = expanded_at(stage);
    const auto rest_of = [&](const Batch& batch) {
      return [this, dt = stage.dt, increment = increments(expanded, stage, q, batch),
              l = batch.values(d)](const Point& point) {
        const Increment at = increment(point);
        const Tensor3<Pack> L = point.gradient(l), F = middle(at);
        const IsotropicTensor<Pack> C = at.stress * dashpot_.stiffness(at.n, dt);
        const Tensor3<Pack> exact = matmul(Pack(at.slope / at.inverse2) * at.F + at.F_change, multiplier(at, L, dt));
        return at.inverse2 * (exact - matmul(F, C(small_strain(matmul(transpose(F), L)))));
      };
    };
    cells_.add_forces(rest_of, r);
  }

  /// dP = dF S + F C:dD is, but for the factor dD/dE, Saint Venant-Kirchhoff's. The rate's is dF S + F C:sym((F +
  /// dF0)^T dF), dF0 = F - F0 - 2 k dt F, without symmetry; with F + dF0/2 on both sides of C it is symmetric and
  /// differs in the first order of dF0 by a skew part alone.
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const auto expanded = expanded_at(stage);
    const auto tangent_of = [&](const Batch& batch) {
      return [this, dt = stage.dt, projection, increment = increments(expanded, stage, q, batch)](const Point& point) {
        const Increment d = increment(point);
        IsotropicTensor<Pack> C = d.stress * dashpot_.stiffness(d.n, dt);
        Tensor3<Pack> S = C(d.D), F = d.F;
        if constexpr (reference == Reference::rate) F = middle(d);
        C = (reference == Reference::rate ? d.inverse2 : d.slope) * C;
        // The part F C F is already semidefinite.
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(S);
        return SaintVenantKirchhoff<Pack>::Linearization<Pack>{C.shear, C.lambda(), F, S, {}}.tangent();
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  std::size_t num_internal() const override {
    return reference == Reference::internal ? num_symmetric * cells_.num_points() : 0;
  }

  void place_internal(std::span<InternalPlace> places) const override {
    if (reference == Reference::internal) place_points(cells_, 0, places);
  }

  void end_stage(const LocalStage& stage, std::span<const double> q, std::span<double> z) const override {
    if constexpr (reference == Reference::internal) {
      const double share = stage.dt / (dashpot_.relaxation_time + stage.dt);
      const auto expanded = expanded_at(stage);
      cells_.for_each_batch([&](const Batch& batch) {
        const auto increment = increments(expanded, stage, q, batch);
        for_each_point(batch, [&](const Point& point) {
          store_symmetric(point, load_symmetric(point, stage.z0) + share * increment(point).E_change, z);
        });
      });
    }
  }

  void complete_step(std::span<const double> /*accepted_z*/, std::span<const double> q,
                     std::span<double> z) const override {
    if (reference != Reference::internal || dashpot_.relaxation_time > 0.0) return;
    cells_.for_each_batch([&](const Batch& batch) {
      const auto u = batch.values(q);
      for_each_point(batch, [&](const Point& point) { store_symmetric(point, green_lagrange(point.gradient(u)), z); });
    });
  }

  /// 1/2 (E - G):eta/tau:(E - G), stored in the spring.
  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> z) const override {
    if (reference != Reference::internal || dashpot_.relaxation_time == 0.0) return 0.0;
    const auto expanded = expanded_points(expansion_.get(), at, ExpansionSplit::multiplicative);
    return cells_.integrate([&](const Batch& batch) {
      return [this, z, &expanded, u = batch.values(q)](const Point& point) {
        const ExpandedPoint& there = expanded[point.index()];
        const Tensor3<Pack> D = green_lagrange(there.strain(point.gradient(u))) - load_symmetric(point, z);
        return 0.5 * there.volume * dot(D, dashpot_.stiffness(point.index(), 0.0)(D));
      };
    });
  }

  /// d/dt (s^3 y(E_e)) at fixed E and G: s^3 k (3 y - S : C_e), with y = 0 without a spring.
  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!expansion_) return 0.0;
    const bool has_spring = dashpot_.relaxation_time > 0.0;
    return integrate(stage, q, [&](const Increment& d) {
      const Tensor3<Pack> S = dashpot_.stiffness(d.n, stage.dt)(d.D);
      const Tensor3<Pack> C_e = d.inverse2 * matmul(transpose(d.F), d.F);
      if (!has_spring) return Pack(-d.volume * d.rate * dot(S, C_e));
      const Tensor3<Pack> left = (dashpot_.relaxation_time / (dashpot_.relaxation_time + stage.dt)) * d.D;  // E_e - G
      return Pack(d.volume * d.rate * (1.5 * dot(left, S) - dot(S, C_e)));
    });
  }

  StressPart part() const override { return StressPart::viscous; }

  /// The stress: S = eta Edot of a dashpot alone, whatever the form of its rate within stages; eta/tau (E - G) behind a
  /// spring.
  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const bool has_spring = dashpot_.relaxation_time > 0.0;
    const bool is_at_rest = has_spring ? state.z.empty() : state.v.empty();
    const Expanded expanded = expanded_at(state.at, state.at.time > 0.0 ? state.at.time : 1.0);
    const auto at_points = [&](const Batch& batch) {
      return [&, u = batch.values(state.q), v = batch.values(has_spring ? state.q : state.v)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u);
        const ExpandedPoint& at = expanded.points[point.index()];
        const Pack inverse2 = at.inverse * at.inverse, scale = at.volume * inverse2;
        if (!has_spring) {
          const Tensor3<Pack> F = add_to_diagonal(H, 1.0);
          const Pack k = expanded.rates[point.index()] * at.inverse;
          const Tensor3<Pack> rate = small_strain(matmul(transpose(F), point.gradient(v) - k * F));
          return PointStress{scale * dashpot_.viscosity(point.index())(inverse2 * rate), 0.0};
        }
        const Tensor3<Pack> D = green_lagrange(at.strain(H)) - load_symmetric(point, state.z);
        const Tensor3<Pack> S = dashpot_.stiffness(point.index(), 0.0)(D);
        return PointStress{scale * S, 0.5 * at.volume * dot(D, S)};
      };
    };
    if (!is_at_rest) visit_mean_stresses(cells_, state, StressMeasure::second_piola_kirchhoff, at_points, visit);
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    const double per_time = 1.0 / (dashpot_.relaxation_time + stage.dt);
    return per_time * integrate(stage, q, [&](const Increment& d) {
             return d.volume * dot(d.D, dashpot_.stiffness(d.n, stage.dt)(d.D));
           });
  }

 private:
  /// The expansion of the body, and its rates ds/dt [1/s].
  struct Expanded {
    PerPoint<ExpandedPoint> points;
    PerPoint<Pack> rates{{Pack(0.0)}};
  };
  Expanded expanded_at(const Instant& at, double time_scale) const {
    Expanded result{expanded_points(expansion_.get(), at, ExpansionSplit::multiplicative)};
    if (expansion_) result.rates = expansion_->stretch().rates(at, time_scale);
    return result;
  }
  Expanded expanded_at(const LocalStage& stage) const { return expanded_at(instant_of(stage), stage.dt); }

  /// The stage at a point. D = E_e - G0, or its replacement; D_change = D - D at q0, summed from dH, so that the digits
  /// of a stiff body's small strains are kept.
  struct Increment {
    std::size_t n;  // number of the pack
    Tensor3<Pack> F, F_change, D, D_change;
    Tensor3<Pack> E_change;               // of what the internal variable follows: E of a dashpot alone, else E_e
    Pack inverse2, volume, stress, rate;  // 1/s^2, s^3, s, k
    Pack slope;                           // dD/dE
  };

  /// Increments of a batch as a function of the point.
  PLIANT_INLINE auto increments(const Expanded& expanded, const LocalStage& stage, std::span<const double> q,
                                const Batch& batch) const {
    assert(reference != Reference::internal || !stage.z0.empty());
    const bool has_spring = dashpot_.relaxation_time > 0.0;
    return [&expanded, has_spring, dt = stage.dt, z0 = stage.z0, u0 = batch.values(stage.q0),
            du = batch.change(q, stage.q0)](const Point& point) {
      const Tensor3<Pack> H0 = point.gradient(u0), dH = point.gradient(du);
      const ExpandedPoint& at = expanded.points[point.index()];
      Increment d;
      d.n = point.index();
      d.F = add_to_diagonal(H0 + dH, 1.0);
      d.F_change = dH;
      d.inverse2 = at.inverse * at.inverse;
      d.volume = at.volume;
      d.stress = at.volume * d.inverse2;
      d.rate = at.inverse * expanded.rates[point.index()];
      d.slope = has_spring ? d.inverse2 : Pack(d.inverse2 * (1.0 - 2.0 * dt * d.rate));
      Tensor3<Pack> change;
      if constexpr (reference == Reference::rate) {
        change = small_strain(matmul(transpose(d.F), dH));
      } else {
        change = green_lagrange_change(H0, dH);
      }
      d.D_change = d.slope * change;
      if (has_spring) {
        d.E_change = d.D = d.D_change + (green_lagrange(at.strain(H0)) - load_symmetric(point, z0));
        return d;
      }
      if constexpr (reference == Reference::internal)
        change = change + (green_lagrange(H0) - load_symmetric(point, z0));
      d.E_change = change;
      d.D = d.inverse2 * (change - Pack(dt * d.rate) * matmul(transpose(d.F), d.F));
      return d;
    };
  }

  /// F + dF0/2 of add_hessian.
  PLIANT_INLINE static Tensor3<Pack> middle(const Increment& d) {
    return Pack(0.5 + 0.5 * d.slope / d.inverse2) * d.F + 0.5 * d.F_change;
  }
  /// Y, of P : L.
  PLIANT_INLINE Tensor3<Pack> multiplier(const Increment& d, const Tensor3<Pack>& L, double dt) const {
    return d.stress * dashpot_.stiffness(d.n, dt)(small_strain(matmul(transpose(d.F), L)));
  }

  PLIANT_INLINE auto stresses_of(const Expanded& expanded, const LocalStage& stage, std::span<const double> q) const {
    return [this, &expanded, &stage, q](const Batch& batch) {
      return [this, dt = stage.dt, increment = increments(expanded, stage, q, batch)](const Point& point) {
        const Increment d = increment(point);
        return d.stress * matmul(d.F, dashpot_.stiffness(d.n, dt)(d.D));  // P = F S
      };
    };
  }

  template <class Density>
  double integrate(const LocalStage& stage, std::span<const double> q, Density density) const {
    const auto expanded = expanded_at(stage);
    return cells_.integrate([&](const Batch& batch) {
      return [density, increment = increments(expanded, stage, q, batch)](const Point& point) {
        return density(increment(point));
      };
    });
  }

  template <class Visit>
  static void for_each_point(const Batch& batch, Visit visit) {
    for (int k = 0; k < batch.group.rule.size(); ++k) visit(Point{batch, k});
  }

  Dashpot dashpot_;
  BodyCells<Order> cells_;
  std::shared_ptr<const FreeExpansion> expansion_;
};

template <Reference reference>
constexpr std::integral_constant<Reference, reference> from{};

}  // namespace

template <int Order>
std::unique_ptr<EnergyTerm> make_viscous_term(const ViscosityVariant& law, const LawField& elastic,
                                              const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes,
                                              std::shared_ptr<const FreeExpansion> expansion) {
  BodyCells<Order> cells(groups, body, num_owned_nodes);
  const auto make = [&](auto reference, Dashpot dashpot) -> std::unique_ptr<EnergyTerm> {
    return std::make_unique<ViscousTerm<Order, decltype(reference)::value>>(std::move(dashpot), std::move(cells),
                                                                            std::move(expansion));
  };
  const auto make_alone = [&](Dashpot dashpot, StrainRate rate) {
    switch (rate) {
      case StrainRate::secant:
        return make(from<Reference::start>, std::move(dashpot));
      case StrainRate::reconstructed:
        return make(from<Reference::internal>, std::move(dashpot));
      case StrainRate::exact:
        break;
    }
    return make(from<Reference::rate>, std::move(dashpot));
  };
  const auto uniform = [](double shear, double bulk) { return std::vector{IsotropicTensor<Pack>{shear, bulk}}; };
  const auto proportional = [&](double shear, double bulk) {
    std::vector<IsotropicTensor<Pack>> viscosities(cells.num_packs());
    for (std::size_t n = 0; n < viscosities.size(); ++n) {
      const auto C0 = tangent_at_rest(elastic, n);
      viscosities[n] = {shear * C0.shear, bulk * C0.bulk};
    }
    return viscosities;
  };
  if (const auto* m = std::get_if<Maxwell>(&law)) {
    const double tau = m->relaxation_time, shear = tau * m->shear_modulus, bulk = tau * m->bulk_modulus;
    return make(from<Reference::internal>,
                {m->name, m->moduli == Moduli::relative ? proportional(shear, bulk) : uniform(shear, bulk), tau});
  }
  if (const auto* s = std::get_if<WithStrainRate<StiffnessProportional>>(&law)) {
    const double of_bulk = s->law.resists_dilatation ? s->law.time : 0.0;
    return make_alone({s->name, proportional(s->law.time, of_bulk), 0.0}, s->rate);
  }
  const auto& [k, rate] = std::get<WithStrainRate<KelvinVoigt>>(law);
  return make_alone({k.name, uniform(k.shear, k.bulk), 0.0}, rate);
}

#define PLIANT_INSTANTIATE(Order)                                                                         \
  template std::unique_ptr<EnergyTerm> make_viscous_term<Order>(const ViscosityVariant&, const LawField&, \
                                                                const CellGroups<Order>&, int, PetscInt,  \
                                                                std::shared_ptr<const FreeExpansion>);
PLIANT_INSTANTIATE(1)
PLIANT_INSTANTIATE(2)
#undef PLIANT_INSTANTIATE

StrainRate strain_rate_for(const Method& method) {
  if (method.order == 1) return StrainRate::secant;
  return keeps_order_with_reconstructed_rates(method) ? StrainRate::reconstructed : StrainRate::exact;
}

}  // namespace pliant
