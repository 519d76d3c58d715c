#include "energy/volume/mean_dilatation.hpp"

#include "base/limits.hpp"
#include "energy/volume/body_law.hpp"
#include "energy/volume/elastic_cells.hpp"
#include "energy/volume/recovery_error.hpp"
#include "material/dilatation.hpp"
#include "material/kinematics.hpp"
#include "material/projection.hpp"

#include <vector>

namespace pliant {
namespace {

constexpr int order = 2;
constexpr int num_nodes = CellGroup<order>::num_nodes;
using Batch = CellBatch<order>;
using QuadraturePoint = CellPoint<order>;
using Nodes = NodeValues<num_nodes>;
using Mask = Pack::mask_type;

/// How the volumes of the points of a batch share a change of the cells' volume: s^3 over its mean in the cell.
struct VolumeShares {
  std::vector<Pack> changes;  ///< m - 1
  std::vector<Pack> rates;    ///< dm/dt [1/s], if asked for

  void set(const Batch& batch, const PerPoint<ExpandedPoint>& points, const PerPoint<Pack>* rates_of_expansion) {
    const auto n = static_cast<std::size_t>(batch.group.rule.size());
    changes.assign(n, Pack(0.0));
    rates.assign(n, Pack(0.0));
    if (points.values.size() <= 1) return;
    Pack size = 0.0, volume = 0.0, growth = 0.0;
    const auto at = [&](std::size_t k) { return QuadraturePoint{batch, static_cast<int>(k)}; };
    const auto rate = [&](std::size_t k) {  // d(s^3)/dt
      const ExpandedPoint& there = points[at(k).index()];
      return rates_of_expansion == nullptr
                 ? Pack(0.0)
                 : Pack(3.0 * there.volume * there.inverse * (*rates_of_expansion)[at(k).index()]);
    };
    for (std::size_t k = 0; k < n; ++k) {
      size += at(k).weight();
      volume += at(k).weight() * points[at(k).index()].volume;
      growth += at(k).weight() * rate(k);
    }
    size = select(size > 0.0, size, Pack(1.0));  // padding lanes have none
    const Pack mean = select(volume > 0.0, volume / size, Pack(1.0));
    for (std::size_t k = 0; k < n; ++k) {
      const Pack& s3 = points[at(k).index()].volume;
      changes[k] = (s3 - mean) / mean;
      rates[k] = (rate(k) - s3 / mean * (growth / size)) / mean;
    }
  }
};

/// The cells of a batch under a displacement: their points, and what these have in common.
class BatchState {
 public:
  void set(const Batch& batch, const Nodes& u, const VolumeShares& shares) {
    const int n = batch.group.rule.size();
    weights_.clear();
    points_.clear();
    volume_ = 0.0;
    valid_ = Mask(true);
    std::vector<Tensor3<Pack>>& H = gradients_;
    H.clear();
    Pack theta_change = 0.0;
    for (int k = 0; k < n; ++k) {
      const QuadraturePoint point{batch, k};
      weights_.push_back(point.weight());
      H.push_back(point.gradient(u));
      const Pack j = volume_change(H.back());
      valid_ = valid_ && j > -1.0;
      volume_ += weights_.back();
      theta_change += weights_.back() * j;
    }
    share_ = 1.0 / select(volume_ > 0.0, volume_, Pack(1.0));
    // Inverted cells are treated as at rest: their results are replaced.
    theta_change_ = select(valid_, theta_change * share_, Pack(0.0));
    for (std::size_t k = 0; k < H.size(); ++k) points_.push_back(at_gradient(H[k], shares.changes[k]));
  }

  /// A point of these cells, at any position, with its share of the volume less 1.
  Dilated<Pack> at_gradient(Tensor3<Pack> H, const Pack& share) const {
    for (Pack& h : H.a) h = select(valid_, h, Pack(0.0));
    return dilated(H, volume_change(H), Pack(theta_change_ + share * (1.0 + theta_change_)));
  }

  std::size_t size() const { return points_.size(); }
  const Dilated<Pack>& point(std::size_t k) const { return points_[k]; }
  const Tensor3<Pack>& gradient(std::size_t k) const { return gradients_[k]; }
  const Pack& weight(std::size_t k) const { return weights_[k]; }
  /// Lanes where J > 0 at all points.
  const Mask& valid() const { return valid_; }
  const Pack& theta_change() const { return theta_change_; }
  Pack mean(const Pack& integral) const { return integral * share_; }

 private:
  std::vector<Dilated<Pack>> points_;
  std::vector<Tensor3<Pack>> gradients_;
  std::vector<Pack> weights_;
  Pack volume_, share_, theta_change_;
  Mask valid_;
};

/// f_a += S . dN_a, S as pulled back.
void add_force(const Tensor3<Pack>& S, const CellGroup<order>::ShapeGradients& dN, Nodes& f) {
  for (int a = 0; a < num_nodes; ++a) {
    for (int i = 0; i < 3; ++i) f[a][i] += S(i, 0) * dN[a][0] + S(i, 1) * dN[a][1] + S(i, 2) * dN[a][2];
  }
}

/// The quadratic form (dF, dtheta) of a point, made positive semidefinite as a whole.
void project(DilatedTangent<Pack>& at) {
  std::array<Pack, 100> M;
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) M[10 * p + q] = at.FF[9 * p + q];
    M[10 * p + 9] = M[90 + p] = at.coupling.a[p];
  }
  M[99] = at.thetatheta;
  project_to_positive_semidefinite(M);
  for (std::size_t p = 0; p < 9; ++p) {
    for (std::size_t q = 0; q < 9; ++q) at.FF[9 * p + q] = M[10 * p + q];
    at.coupling.a[p] = M[10 * p + 9];
  }
  at.thetatheta = M[99];
}

class MeanDilatationTerm final : public ElasticTerm {
 public:
  MeanDilatationTerm(BodyLaw law, const CellGroups<order>& groups, int body, PetscInt num_owned_nodes)
      : law_(std::move(law)), cells_(groups, body, num_owned_nodes), num_owned_nodes_(num_owned_nodes) {}

  std::string_view name() const override { return "elastic"; }
  TermDeclaration declaration() const override { return {.depends_on_time = law_.depends_on_time()}; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    BatchState start;
    VolumeShares shares;
    std::vector<Tensor3<Pack>> dF;
    std::vector<Pack> dJ;
    return sum_over_cells([&](const Batch& batch) {
      shares.set(batch, expanded, nullptr);
      start.set(batch, batch.values(stage.reference()), shares);
      const Nodes du = batch.change(q, stage.reference());
      dF.clear();
      dJ.clear();
      Mask valid = start.valid();
      Pack dtheta = 0.0;
      for (std::size_t k = 0; k < start.size(); ++k) {
        dF.push_back(QuadraturePoint{batch, static_cast<int>(k)}.gradient(du));
        dJ.push_back(det_change(start.point(k).F, dF.back()));
        valid = valid && start.point(k).J + dJ.back() > 0.0;
        dtheta += start.weight(k) * dJ.back();
      }
      dtheta = start.mean(dtheta);
      Pack energy = 0.0;
      for (std::size_t k = 0; k < start.size(); ++k) {
        for (Pack& h : dF[k].a) h = select(valid, h, Pack(0.0));
        const Tensor3<Pack> change = dilated_change(start.point(k), dF[k], select(valid, dJ[k], Pack(0.0)),
                                                    select(valid, Pack((1.0 + shares.changes[k]) * dtheta), Pack(0.0)));
        energy += start.weight(k) * law->psi_change(index(batch, k), start.point(k).H, change);
      }
      return select(valid, energy, Pack(infinity));
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& instant, std::span<const double> q, std::span<const double> /*z*/) const override {
    const BodyLaw::Now law = law_.at(instant);
    const auto expanded = law_.expanded(instant);
    BatchState at;
    VolumeShares shares;
    return sum_over_cells([&](const Batch& batch) {
      shares.set(batch, expanded, nullptr);
      at.set(batch, batch.values(q), shares);
      Pack energy = 0.0;
      for (std::size_t k = 0; k < at.size(); ++k) energy += at.weight(k) * law->psi(index(batch, k), at.point(k).H);
      return select(at.valid(), energy, Pack(infinity));
    });
  }

  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!law_.depends_on_time()) return 0.0;
    const BodyLaw::Supply power = law_.supply(stage);
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    const PerPoint<Pack> rates = law_.rates_of_expansion(stage);
    BatchState at;
    VolumeShares shares;
    return sum_over_cells([&](const Batch& batch) {
      shares.set(batch, expanded, &rates);
      at.set(batch, batch.values(q), shares);
      Pack total = 0.0;
      for (std::size_t k = 0; k < at.size(); ++k) {
        const Dilated<Pack>& point = at.point(k);
        const Pack pressure = DilatedStress<Pack>(point, law->P(index(batch, k), point.H)).pressure;
        total +=
            at.weight(k) * (power(index(batch, k), point.H) + pressure * (1.0 + at.theta_change()) * shares.rates[k]);
      }
      return total;
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    for_each_force(stage, q,
                   [&](const Batch& batch, const Nodes& f) { scatter_add<order>(batch.batch(), f, r.data()); });
  }

  bool has_adjoint() const override { return true; }
  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override {
    for_each_force(stage, q, [&](const Batch& batch, const Nodes& f) {
      const Nodes change = batch.values(d);
      Pack work = 0.0;
      for (std::size_t a = 0; a < f.size(); ++a) {
        for (int i = 0; i < 3; ++i) work += f[a][i] * change[a][i];
      }
      batch.add_to_cells(work, works);
    });
  }

  /// Calls `visit(batch, the forces of its cells on their nodes)`.
  template <class Visit>
  void for_each_force(const LocalStage& stage, std::span<const double> q, Visit visit) const {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    BatchState at;
    VolumeShares shares;
    std::vector<DilatedStress<Pack>> stress;
    cells_.for_each_batch([&](const Batch& batch) {
      shares.set(batch, expanded, nullptr);
      at.set(batch, batch.values(q), shares);
      stress.clear();
      const Pack p = pressure(*law, batch, at, shares, stress);
      Nodes f{};
      for (std::size_t k = 0; k < at.size(); ++k) {
        const QuadraturePoint point{batch, static_cast<int>(k)};
        const Tensor3<Pack> P = stress[k].distortion + Pack(p * at.point(k).J) * at.point(k).G;
        add_force(at.weight(k) * pulled_back(P, point.inverse_jacobian()), point.shape_gradients(), f);
      }
      for (auto& node : f) {
        for (Pack& component : node) component = select(at.valid(), component, Pack(nan));
      }
      visit(batch, f);
    });
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    const auto expanded = law_.expanded(instant_of(stage));
    BatchState at;
    VolumeShares shares;
    std::vector<DilatedStress<Pack>> stress;
    CellMatrix<num_nodes> matrix;
    std::vector<LinearMatrix> points;
    Tangent<Pack> Ab;
    cells_.for_each_batch([&](const Batch& batch) {
      shares.set(batch, expanded, nullptr);
      at.set(batch, batch.values(q), shares);
      stress.clear();
      Pack p = pressure(*law, batch, at, shares, stress);
      if (!stage.previous.empty()) p += pressure_error(*law, batch, shares, {q, stage.previous}, p);
      points.resize(at.size());
      Nodes g{}, h{};
      Pack k_theta = 0.0;
      for (std::size_t k = 0; k < at.size(); ++k) {
        const QuadraturePoint point{batch, static_cast<int>(k)};
        const auto& X = point.inverse_jacobian();
        const auto& dN = point.shape_gradients();
        const Pack& w = at.weight(k);
        law->tangent(index(batch, k), at.point(k).H, Ab);
        DilatedTangent<Pack> tangent(at.point(k), law->P(index(batch, k), at.point(k).H), Ab, p);
        const Pack share = 1.0 + shares.changes[k];
        tangent.coupling = share * tangent.coupling;
        tangent.thetatheta *= share * share;
        if (projection == Projection::positive_semidefinite) project(tangent);
        for (Pack& entry : tangent.FF) entry = select(at.valid(), entry, Pack(nan));
        set_linear_matrix(tangent.FF, X, w, points[k]);
        add_force(w * pulled_back(tangent.coupling, X), dN, h);
        add_force(at.mean(w * at.point(k).J) * pulled_back(at.point(k).G, X), dN, g);
        k_theta += w * tangent.thetatheta;
      }
      set_cell_matrix<order>(batch.group, points, matrix);
      for (int b = 0; b < num_nodes; ++b) {
        for (int a = 0; a <= b; ++a) {
          Tensor3<Pack>& block = matrix.block(a, b);
          for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
              block(i, j) += h[a][i] * g[b][j] + g[a][i] * (h[b][j] + k_theta * g[b][j]);
            }
          }
        }
      }
      scatter_add(batch.group, batch.number, num_owned_nodes_, matrix, K);
    });
  }

  double max_step(const LocalStage& /*stage*/, std::span<const double> q, std::span<const double> d) const override {
    return step_to_inversion(cells_, q, d);
  }

  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const BodyLaw::Now law = law_.at(state.at), at_centres = law_.at_centroids(state.at, cells_);
    const auto expanded = law_.expanded(state.at), of_centres = law_.expanded_at_centroids(state.at, cells_);
    BatchState at;
    VolumeShares shares;
    std::vector<DilatedStress<Pack>> stress;
    cells_.for_each_batch([&](const Batch& batch) {
      const Nodes u = batch.values(state.q);
      shares.set(batch, expanded, nullptr);
      at.set(batch, u, shares);
      stress.clear();
      const Pack p = pressure(*law, batch, at, shares, stress);
      const Tensor3<Pack> H = centroid_gradient(batch, u);
      const std::size_t first = index(batch, 0);
      const Pack s3 = expanded[first].volume / (1.0 + shares.changes[0]);  // its mean over the cell
      const Dilated<Pack> centre = at.at_gradient(H, Pack(of_centres[first].volume / s3 - 1.0));
      const DilatedStress<Pack> there(centre, at_centres->P(first, centre.H));
      visit_stresses(batch,
                     {H, there.distortion + Pack(p * centre.J) * centre.G, 1.0 + at.theta_change(),
                      at_centres->psi(first, centre.H)},
                     state.visited, visit);
    });
  }

  /// The error is that of the distortion: volumes of recovered gradients are less accurate than those of the cells.
  void recovery_errors(const RecoveredState& state, const RecoveryErrorVisitor& visit) const override {
    const BodyLaw::Now law = law_.at_centroids(state.at, cells_);
    const auto stresses_of = [&](const Batch& batch, const RecoveryPoints<order>& points,
                                 std::span<const Tensor3<Pack>> gradients) {
      return distortions(*law, index(batch, 0), points.weights, gradients);
    };
    visit_recovery_errors(cells_, state, StressMeasure::second_piola_kirchhoff, stresses_of, visit);
  }

 private:
  /// Psi_F at points of these volumes in cells with these gradients.
  static std::vector<Tensor3<Pack>> distortions(const LawField& law, std::size_t n, std::span<const Pack> weights,
                                                std::span<const Tensor3<Pack>> gradients) {
    Pack volume = 0.0, change = 0.0;
    Mask valid(true);
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const Pack j = volume_change(gradients[k]);
      valid = valid && j > -1.0;
      change += weights[k] * j;
      volume += weights[k];
    }
    const Pack theta_change = select(valid, change / volume, Pack(0.0));
    std::vector<Tensor3<Pack>> result;
    for (Tensor3<Pack> H : gradients) {
      for (Pack& h : H.a) h = select(valid, h, Pack(0.0));
      const Dilated<Pack> at = dilated(H, volume_change(H), theta_change);
      result.push_back(DilatedStress<Pack>(at, law.P(n, at.H)).distortion);
    }
    return result;
  }

  static std::size_t index(const Batch& batch, std::size_t k) {
    return QuadraturePoint{batch, static_cast<int>(k)}.index();
  }

  /// Computes the pressure of the cells, and the stresses of their points on the way.
  static Pack pressure(const LawField& law, const Batch& batch, const BatchState& at, const VolumeShares& shares,
                       std::vector<DilatedStress<Pack>>& stress) {
    Pack integral = 0.0;
    for (std::size_t k = 0; k < at.size(); ++k) {
      stress.emplace_back(at.point(k), law.P(index(batch, k), at.point(k).H));
      integral += at.weight(k) * (1.0 + shares.changes[k]) * stress.back().pressure;
    }
    return at.mean(integral);
  }

  /// The displacements of an iteration.
  struct Iterates {
    std::span<const double> q, previous;
  };

  /// The difference between the pressure at q and the one extrapolated from `previous` (extrapolation_error).
  static Pack pressure_error(const LawField& law, const Batch& batch, const VolumeShares& shares,
                             const Iterates& iterates, const Pack& p) {
    constexpr double part = 1e-3;
    BatchState at;
    std::vector<DilatedStress<Pack>> stress;
    const Nodes u = batch.values(iterates.previous), du = batch.change(iterates.q, iterates.previous);
    const auto at_part = [&](double way) {
      Nodes there = u;
      for (std::size_t a = 0; a < there.size(); ++a) {
        for (int i = 0; i < 3; ++i) there[a][i] += way * du[a][i];
      }
      at.set(batch, there, shares);
      stress.clear();
      return select(at.valid(), pressure(law, batch, at, shares, stress), Pack(nan));
    };
    const Pack extrapolated = at_part(0.0) + (0.5 / part) * (at_part(part) - at_part(-part));
    const Pack error = extrapolated - p;
    return select(std::experimental::isfinite(error), error, Pack(0.0));
  }

  /// Compensated sum over the owned cells of `energy_of(batch)`; +inf if one is not a number.
  template <class EnergyOf>
  double sum_over_cells(const EnergyOf& energy_of) const {
    CompensatedSum<Pack> total;
    cells_.for_each_batch(
        [&](const Batch& batch) { total.add(select(batch.batch().owned > 0.0, energy_of(batch), Pack(0.0))); });
    const double result = sum(total.total());
    return std::isnan(result) ? infinity : result;
  }

  BodyLaw law_;
  BodyCells<order> cells_;
  PetscInt num_owned_nodes_;
};

}  // namespace

std::unique_ptr<ElasticTerm> make_mean_dilatation_term(std::shared_ptr<const LawField> law, const CellGroups<2>& groups,
                                                       int body, PetscInt num_owned_nodes, FreeShape shape) {
  return std::make_unique<MeanDilatationTerm>(BodyLaw(std::move(law), std::move(shape)), groups, body, num_owned_nodes);
}

}  // namespace pliant
