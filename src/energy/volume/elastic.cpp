#include "energy/volume/elastic.hpp"

#include "energy/volume/body_law.hpp"
#include "energy/volume/elastic_cells.hpp"
#include "energy/volume/recovery_error.hpp"
#include "material/projection.hpp"

namespace pliant {
namespace {

template <int Order>
class ElasticTermOf final : public ElasticTerm {
  using Batch = CellBatch<Order>;
  using Point = CellPoint<Order>;

 public:
  ElasticTermOf(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups, int body,
                PetscInt num_owned_nodes, FreeShape shape)
      : law_(std::move(law), std::move(shape)), cells_(groups, body, num_owned_nodes) {}

  std::string_view name() const override { return "elastic"; }
  TermDeclaration declaration() const override {
    return {.depends_on_time = law_.depends_on_time(), .rotates_with_body = !law_.traits().constant_tangent};
  }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    return cells_.integrate([&](const Batch& batch) {
      return [&law, u0 = batch.values(stage.reference()), du = batch.change(q, stage.reference())](const Point& point) {
        return law->psi_change(point.index(), point.gradient(u0), point.gradient(du));
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> z) const override { return energy_at({}, q, z); }

  double energy_at(const Instant& at, std::span<const double> q, std::span<const double> /*z*/) const override {
    const BodyLaw::Now law = law_.at(at);
    return cells_.integrate([&](const Batch& batch) {
      return [&law, u = batch.values(q)](const Point& point) { return law->psi(point.index(), point.gradient(u)); };
    });
  }

  double supply(const LocalStage& stage, std::span<const double> q) const override {
    if (!law_.depends_on_time()) return 0.0;
    const BodyLaw::Supply power = law_.supply(stage);
    return cells_.integrate([&](const Batch& batch) {
      return [&power, u = batch.values(q)](const Point& point) { return power(point.index(), point.gradient(u)); };
    });
  }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    cells_.add_forces(stresses_of(law, q), r);
  }

  bool has_adjoint() const override { return true; }
  void add_cell_works(const LocalStage& stage, std::span<const double> q, std::span<const double> d,
                      std::span<double> works) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    cells_.add_works(stresses_of(law, q), d, works);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const BodyLaw::Now law = law_.at(instant_of(stage));
    // Stresses of linear elasticity are evaluated at the extrapolated displacements.
    const bool extrapolates = !stage.previous.empty() && !law_.traits().constant_tangent;
    const auto tangent_of = [&](const Batch& batch) {
      const auto u = batch.values(q), du = extrapolates ? batch.change(q, stage.previous) : u;
      return [&law, projection, extrapolates, u, du](const Point& point) {
        Tangent<Pack> A;
        const Tensor3<Pack> H = point.gradient(u);
        law->tangent(point.index(), H, A);
        if (extrapolates) {
          const auto S = [&](const Tensor3<Pack>& at) { return second_stress(at, law->P(point.index(), at)); };
          add_geometric_stiffness(extrapolation_error(S, H, point.gradient(du)), A);
        }
        if (projection == Projection::positive_semidefinite) project_to_positive_semidefinite(A, H);
        return A;
      };
    };
    cells_.add_stiffness(tangent_of, K);
  }

  double max_step(const LocalStage& /*stage*/, std::span<const double> q, std::span<const double> d) const override {
    if (!law_.traits().is_barrier) return std::numeric_limits<double>::infinity();
    return step_to_inversion(cells_, q, d);
  }

  void stresses(const BodyState& state, const StressVisitor& visit) const override {
    const BodyLaw::Now law = law_.at_centroids(state.at, cells_);
    cells_.for_each_batch([&](const Batch& batch) {
      const Tensor3<Pack> H = centroid_gradient(batch, batch.values(state.q));
      const std::size_t n = Point{batch, 0}.index();
      visit_stresses(batch, {H, law->P(n, H), det(add_to_diagonal(H, 1.0)), law->psi(n, H)}, state.visited, visit);
    });
  }

  void recovery_errors(const RecoveredState& state, const RecoveryErrorVisitor& visit) const override {
    visit_recovery_errors(cells_, state, *law_.at_centroids(state.at, cells_), visit);
  }

 private:
  static auto stresses_of(const BodyLaw::Now& law, std::span<const double> q) {
    return [&law, q](const Batch& batch) {
      return [&law, u = batch.values(q)](const Point& point) { return law->P(point.index(), point.gradient(u)); };
    };
  }

  BodyLaw law_;
  BodyCells<Order> cells_;
};

}  // namespace

template <int Order>
std::unique_ptr<ElasticTerm> make_elastic_term(std::shared_ptr<const LawField> law, const CellGroups<Order>& groups,
                                               int body, PetscInt num_owned_nodes, FreeShape shape) {
  return std::make_unique<ElasticTermOf<Order>>(std::move(law), groups, body, num_owned_nodes, std::move(shape));
}

template <int Order>
std::unique_ptr<LawField> make_varying_law(
    const ElasticLawSpec& common, const NodeLayout& layout, const CellGroups<Order>& groups, int body,
    const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>& at) {
  const std::vector<PackPlaces> places = places_of_points<Order>(layout, groups, body);
  return make_law_field(common, places.size(),
                        [&](std::size_t n, int lane) { return at(places[n].cell[lane], places[n].X[lane]); });
}

#define PLIANT_INSTANTIATE(Order)                                                                                     \
  template std::unique_ptr<ElasticTerm> make_elastic_term<Order>(std::shared_ptr<const LawField>,                     \
                                                                 const CellGroups<Order>&, int, PetscInt, FreeShape); \
  template std::unique_ptr<LawField> make_varying_law<Order>(                                                         \
      const ElasticLawSpec&, const NodeLayout&, const CellGroups<Order>&, int,                                        \
      const std::function<ElasticLawSpec(PetscInt, const std::array<double, 3>&)>&);
PLIANT_INSTANTIATE(1)
PLIANT_INSTANTIATE(2)
#undef PLIANT_INSTANTIATE

int elastic_quadrature_degree(const LawTraits& law, int order) {
  return (order - 1) * law.energy_degree;  // H is a polynomial of degree order - 1
}

}  // namespace pliant
