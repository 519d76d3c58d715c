#include "energy/volume/mixed.hpp"

#include "base/limits.hpp"
#include "energy/volume/body_law.hpp"
#include "energy/volume/elastic_cells.hpp"
#include "energy/volume/recovery_error.hpp"
#include "material/kinematics.hpp"
#include "material/projection.hpp"
#include "petsc/ghosted.hpp"

#include <algorithm>
#include <vector>

namespace pliant {
namespace {

using Lanes = PressureCoupling::Lanes;
using PressureMatrix = std::array<std::array<Pack, 4>, 4>;

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

/// The largest shear moduli in the planes along the axes, of a body at rest at its n-th pack of points [Pa].
Pack stiffness_against_shear(const LawField& law, std::size_t n) {
  Tangent<Pack> A;
  law.tangent(n, Tensor3<Pack>{}, A);
  Pack largest = 0.0;
  for (std::size_t p = 0; p < 9; ++p) {
    if (p % 4 != 0) largest = select(A[9 * p + p] > largest, A[9 * p + p], largest);
  }
  return largest;
}

template <int Order>
class MixedTermOf final : public MixedTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;
  static constexpr int num_nodes = CellGroup<Order>::num_nodes;

 public:
  MixedTermOf(MixedLaw law, const CellGroups<Order>& groups, int body, PetscInt num_owned_nodes,
              const PressureField& pressures, FreeShape shape)
      : law_(law.rest, std::move(shape)),
        compliance_(std::move(law.compliance)),
        form_(law.form),
        cells_(groups, body, num_owned_nodes),
        pressures_(pressures) {
    const auto& of_node = pressures.layout().of_node[static_cast<std::size_t>(body)];
    cells_.for_each_batch([&](const Batch& batch) {
      auto& numbers = numbers_.emplace_back();
      for (int a = 0; a < 4; ++a) {
        for (int lane = 0; lane < pack_size; ++lane) numbers[a][lane] = of_node[batch.batch().nodes[a][lane]];
      }
      const Pack mu = stiffness_against_shear(*law.rest, Point{batch, 0}.index());
      shear_moduli_.push_back(mu);
      shear_modulus_ = std::max(shear_modulus_, static_cast<double>(std::experimental::hmax(mu)));
    });
  }

  std::string_view name() const override { return "volumetric: mixed"; }
  TermDeclaration declaration() const override {
    return {.is_potential = false, .depends_on_time = law_.depends_on_time()};
  }

  /// At the present pressures.
  double value(const LocalStage& stage, std::span<const double> q) const override {
    const ConstGhostedView p(pressures_.values());
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    return integrate([&](const Batch& batch, std::size_t number) {
      return [this, &law, &expanded, u0 = batch.values(stage.reference()), du = batch.change(q, stage.reference()),
              p = gather_pressures(p.span(), number)](const Point& point) {
        const Tensor3<Pack> H0 = point.gradient(u0), dH = point.gradient(du);
        const ExpandedPoint& at = expanded[point.index()];
        const VolumeState before(form_, at.strain(H0)), after(form_, at.strain(H0 + dH));
        const Pack change = law->psi_change(point.index(), H0, dH) +
                            at.volume * pressure_at(point, p) * (after.measure.g - before.measure.g);
        return select(before.valid && after.valid, change, Pack(infinity));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const override {
    const ConstGhostedView p(pressures_.values());
    const BodyLaw::Now law = law_.at(at);
    const auto expanded = law_.expanded(at);
    const double of_cells = integrate([&](const Batch& batch, std::size_t number) {
      return [this, &law, &expanded, u = batch.values(q), p = gather_pressures(p.span(), number)](const Point& point) {
        const std::size_t n = point.index();
        return density(*law, expanded[n], n, point.gradient(u), pressure_at(point, p));
      };
    });
    return of_cells - half_of_squares(p.span(), [&](const Batch& batch, std::size_t number) {
             return pressure_matrix(batch, number, expanded);
           });
  }

  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!law_.depends_on_time()) return 0.0;
    const ConstGhostedView p(pressures_.values());
    const BodyLaw::Supply power = law_.supply(stage);
    const auto expanded = law_.expanded(instant_of(stage));
    const PerPoint<Pack> rates = law_.rates_of_expansion(stage);
    const auto growth = [&](std::size_t n) -> Pack {  // d(s^3)/dt
      return 3.0 * expanded[n].volume * expanded[n].inverse * rates[n];
    };
    const double of_cells = integrate([&](const Batch& batch, std::size_t number) {
      return [this, &power, &expanded, &growth, u = batch.values(q),
              p = gather_pressures(p.span(), number)](const Point& point) {
        const Tensor3<Pack> H = point.gradient(u);
        const VolumeState volume(form_, expanded[point.index()].strain(H));
        const Pack loss = (1.0 + volume.j) * volume.measure.slope;  // d/ds (s^3 g(J/s^3)) = 3 s^2 (g - J_e g')
        return power(point.index(), H) + growth(point.index()) * pressure_at(point, p) * (volume.measure.g - loss);
      };
    });
    return of_cells - half_of_squares(p.span(), [&](const Batch& batch, std::size_t number) {
             return pressure_matrix(batch, number, growth);
           });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const ConstGhostedView p(pressures_.values());
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    std::size_t number = 0;
    const auto stress_of = [&](const Batch& batch) {
      return
          [this, &law, &expanded, u = batch.values(q), p = gather_pressures(p.span(), number++)](const Point& point) {
            const std::size_t n = point.index();
            return stress(*law, expanded[n], n, point.gradient(u), pressure_at(point, p));
          };
    };
    cells_.add_forces(stress_of, r);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const ConstGhostedView p(pressures_.values());
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    std::size_t number = 0;
    const auto tangent_of = [&](const Batch& batch) {
      return [this, &law, &expanded, projection, u = batch.values(q),
              p = gather_pressures(p.span(), number++)](const Point& point) {
        const ExpandedPoint& at = expanded[point.index()];
        const Tensor3<Pack> H = point.gradient(u);
        Tangent<Pack> A;
        law->tangent(point.index(), H, A);
        add_stiffness_of_volume(at.strain(H), Pack(at.volume * at.inverse * at.inverse * pressure_at(point, p)), A);
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A, H);
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
    const BodyLaw::Now law = law_.at_centroids(state.at, cells_);
    const auto expanded = law_.expanded_at_centroids(state.at, cells_);
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const Tensor3<Pack> H = centroid_gradient(batch, batch.values(state.q));
      const std::size_t n = Point{batch, 0}.index();
      const ExpandedPoint& at = expanded[n];
      const auto p = gather_pressures(values.span(), number);
      const Pack mean = 0.25 * ((p[0] + p[1]) + (p[2] + p[3]));
      const Pack energy = density(*law, at, n, H, mean) - 0.5 * at.volume * compliance_[n] * (mean * mean);
      visit_stresses(batch, {H, stress(*law, at, n, H, mean), det(add_to_diagonal(H, 1.0)), energy}, state.visited,
                     visit);
    });
  }

  /// The error is that of the law without its volume: pressures have an error of their own, whose energy is far
  /// smaller.
  void recovery_errors(const RecoveredState& state, const RecoveryErrorVisitor& visit) const override {
    visit_recovery_errors(cells_, state, *law_.at_centroids(state.at, cells_), visit);
  }

  void add_pressure_gradient(const Instant& at, std::span<const double> q, std::span<double> r) const override {
    const ConstGhostedView values(pressures_.values());
    const auto expanded = law_.expanded(at);
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const auto u = batch.values(q);
      auto f = product(pressure_matrix(batch, number, expanded), gather_pressures(values.span(), number));
      for (Pack& entry : f) entry = -entry;
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const ExpandedPoint& there = expanded[point.index()];
        const VolumeState volume(form_, there.strain(point.gradient(u)));
        const Pack g = point.weight() * there.volume * volume.measure.g;
        const auto N = shape_values(point);
        for (int b = 0; b < 4; ++b) f[b] += N[b] * select(volume.valid, g, Pack(nan));
      }
      scatter(batch, number, f, r);
    });
  }

  void add_pressure_volumes(std::span<double> m) const override {
    for_each_batch([&](const Batch& batch, std::size_t number) {
      std::array<Pack, 4> f{};
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const auto N = shape_values(point);
        for (int b = 0; b < 4; ++b) f[b] += N[b] * point.weight();
      }
      scatter(batch, number, f, m);
    });
  }

  void couple(const Instant& at, std::span<const double> q,
              const std::function<void(const PressureCoupling&)>& visit) const override {
    const auto expanded = law_.expanded(at);
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const auto u = batch.values(q);
      std::array<std::array<Pack, 4>, 3 * num_nodes> B{};
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const auto N = shape_values(point);
        const auto& dN = point.shape_gradients();
        const ExpandedPoint& there = expanded[point.index()];
        const Pack weight = point.weight() * there.volume * there.inverse;
        const Tensor3<Pack> H = there.strain(point.gradient(u));
        const VolumeState volume(form_, H);
        const Pack slope = select(volume.valid, volume.measure.slope, Pack(nan));
        const Tensor3<Pack> S =
            Pack(weight * slope) * pulled_back(cofactor(add_to_diagonal(H, 1.0)), point.inverse_jacobian());
        for (int a = 0; a < num_nodes; ++a) {
          for (int i = 0; i < 3; ++i) {
            const Pack s = S(i, 0) * dN[a][0] + S(i, 1) * dN[a][1] + S(i, 2) * dN[a][2];
            for (int b = 0; b < 4; ++b) B[3 * a + i][b] += N[b] * s;
          }
        }
      }
      const PressureMatrix C = pressure_matrix(batch, number, expanded);
      visit({batch.batch().num_lanes, batch.batch().nodes, numbers_[number], B, C,
             compliance_[Point{batch, 0}.index()] > 0.0});
    });
  }

  double shear_modulus() const override { return shear_modulus_; }

 private:
  using Pressures = std::array<Pack, 4>;

  static std::array<double, 4> shape_values(const Point& point) {
    return Tet<1>::values(point.in.group.rule.points[point.number]);
  }
  static Pack pressure_at(const Point& point, const Pressures& p) {
    const auto N = shape_values(point);
    return (N[0] * p[0] + N[1] * p[1]) + (N[2] * p[2] + N[3] * p[3]);
  }

  /// int f N_b N_c / kappa dX, and what S adds with f dX in the place of dX; f(n) is a function of the pack's number.
  template <class F>
  PressureMatrix pressure_matrix(const Batch& batch, std::size_t number, const F& f) const {
    PressureMatrix C{};
    if constexpr (Order == 1) {
      Pack volume = 0.0;
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        volume += point.weight() * f(point.index());
      }
      const Pack compliance = compliance_[Point{batch, 0}.index()], stabilization = 1.0 / shear_moduli_[number];
      for (int b = 0; b < 4; ++b) {
        for (int c = 0; c < 4; ++c) {
          const double mean = b == c ? 1.0 / 10 : 1.0 / 20;  // of N_b N_c; that of N_b is 1/4
          C[b][c] = volume * (compliance * mean + stabilization * (mean - 1.0 / 16));
        }
      }
    } else {
      for (int k = 0; k < batch.group.rule.size(); ++k) {
        const Point point{batch, k};
        const auto N = shape_values(point);
        const Pack weight = point.weight() * f(point.index()) * compliance_[point.index()];
        for (int b = 0; b < 4; ++b) {
          for (int c = 0; c < 4; ++c) C[b][c] += N[b] * N[c] * weight;
        }
      }
    }
    return C;
  }
  /// C of the cells.
  PressureMatrix pressure_matrix(const Batch& batch, std::size_t number,
                                 const PerPoint<ExpandedPoint>& expanded) const {
    return pressure_matrix(batch, number, [&](std::size_t n) { return expanded[n].volume; });
  }
  /// p^T C p / 2 of the owned cells, C = `matrix_of(batch, number)`.
  template <class MatrixOf>
  double half_of_squares(std::span<const double> p, const MatrixOf& matrix_of) const {
    CompensatedSum<Pack> total;
    for_each_batch([&](const Batch& batch, std::size_t number) {
      const auto y = gather_pressures(p, number);
      const auto Cy = product(matrix_of(batch, number), y);
      const Pack half = 0.5 * ((Cy[0] * y[0] + Cy[1] * y[1]) + (Cy[2] * y[2] + Cy[3] * y[3]));
      total.add(select(batch.batch().owned > 0.0, half, Pack(0.0)));
    });
    return sum(total.total());
  }
  static Pressures product(const PressureMatrix& C, const Pressures& p) {
    Pressures result;
    for (int b = 0; b < 4; ++b) result[b] = (C[b][0] * p[0] + C[b][1] * p[1]) + (C[b][2] * p[2] + C[b][3] * p[3]);
    return result;
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

  /// A += p (g'' cof F (x) cof F + g' d cof F/dF), the latter eps_ikm eps_JLN F_mN.
  void add_stiffness_of_volume(const Tensor3<Pack>& H, const Pack& p, Tangent<Pack>& A) const {
    const VolumeState volume(form_, H);
    const Pack at = select(volume.valid, p, Pack(nan));
    const Pack curvature = at * volume.measure.curvature, slope = at * volume.measure.slope;
    const Tensor3<Pack> F = add_to_diagonal(H, 1.0), C = cofactor(F);
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
  }

  Tensor3<Pack> stress(const LawField& law, const ExpandedPoint& at, std::size_t n, const Tensor3<Pack>& H,
                       const Pack& p) const {
    const Tensor3<Pack> H_e = at.strain(H);
    const VolumeState volume(form_, H_e);
    const Pack slope = select(volume.valid, p * volume.measure.slope, Pack(nan));
    return law.P(n, H) + Pack(at.volume * at.inverse * slope) * cofactor(add_to_diagonal(H_e, 1.0));
  }
  /// psi + p g.
  Pack density(const LawField& law, const ExpandedPoint& at, std::size_t n, const Tensor3<Pack>& H,
               const Pack& p) const {
    const VolumeState volume(form_, at.strain(H));
    const Pack value = law.psi(n, H) + at.volume * p * volume.measure.g;
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

  BodyLaw law_;                // with kappa = 0
  PerPoint<Pack> compliance_;  // 1 / kappa
  VolumetricForm form_;
  double shear_modulus_ = 0.0;      // the largest
  std::vector<Pack> shear_moduli_;  // of the cells of each batch
  BodyCells<Order> cells_;
  const PressureField& pressures_;
  std::vector<std::array<Lanes, 4>> numbers_;  // local pressures of each batch
};

}  // namespace

MixedLaw make_mixed_law(const VolumeSplit& uniform) {
  return {make_law_field(uniform.rest), {{Pack(1.0 / uniform.kappa)}}, uniform.form};
}

template <int Order>
MixedLaw make_varying_mixed_law(const ElasticLawSpec& common, VolumetricForm form, const NodeLayout& layout,
                                const CellGroups<Order>& groups, int body,
                                const std::function<VolumeSplit(PetscInt, const std::array<double, 3>&)>& at) {
  const std::vector<PackPlaces> places = places_of_points<Order>(layout, groups, body);
  PerPoint<Pack> compliance;
  compliance.values.resize(std::max<std::size_t>(places.size(), 1));
  auto rest = make_law_field(common, places.size(), [&](std::size_t n, int lane) {
    const VolumeSplit there = at(places[n].cell[lane], places[n].X[lane]);
    compliance.values[n][lane] = 1.0 / there.kappa;
    return there.rest;
  });
  return {std::move(rest), std::move(compliance), form};
}

template <int Order>
std::unique_ptr<MixedTerm> make_mixed_term(MixedLaw law, const CellGroups<Order>& groups, int body,
                                           PetscInt num_owned_nodes, const PressureField& pressures, FreeShape shape) {
  return std::make_unique<MixedTermOf<Order>>(std::move(law), groups, body, num_owned_nodes, pressures,
                                              std::move(shape));
}

#define PLIANT_INSTANTIATE(Order)                                                                               \
  template MixedLaw make_varying_mixed_law<Order>(                                                              \
      const ElasticLawSpec&, VolumetricForm, const NodeLayout&, const CellGroups<Order>&, int,                  \
      const std::function<VolumeSplit(PetscInt, const std::array<double, 3>&)>&);                               \
  template std::unique_ptr<MixedTerm> make_mixed_term<Order>(MixedLaw, const CellGroups<Order>&, int, PetscInt, \
                                                             const PressureField&, FreeShape);
PLIANT_INSTANTIATE(1)
PLIANT_INSTANTIATE(2)
#undef PLIANT_INSTANTIATE

}  // namespace pliant
