#include "energy/shell/membrane.hpp"

#include "base/vector3.hpp"
#include "energy/shell/layer_facets.hpp"
#include "energy/volume/elastic.hpp"

#include <eigen3/Eigen/Eigenvalues>

namespace pliant {
namespace {

template <int Order>
using SharedFacets = std::shared_ptr<const LayerFacets<Order>>;
using SharedLaw = std::shared_ptr<const PlaneStress>;

/// Lane by lane the nearest matrix without negative eigenvalues.
void make_positive_semidefinite(LayerTangent& T) {
  using Matrix = Eigen::Matrix<double, 6, 6>;
  for (int lane = 0; lane < pack_size; ++lane) {
    Matrix M;
    for (Eigen::Index p = 0; p < 36; ++p) M(p / 6, p % 6) = T[static_cast<std::size_t>(p)][lane];
    if (!M.allFinite()) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(M);
    if (solver.eigenvalues()[0] >= 0.0) continue;
    M = (solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * solver.eigenvectors().transpose())
            .eval();
    for (Eigen::Index p = 0; p < 36; ++p) T[static_cast<std::size_t>(p)][lane] = M(p / 6, p % 6);
  }
}

template <int Order>
class Membrane final : public LayerTerm {
  using Facets = LayerFacets<Order>;
  using Batch = LayerBatch<Order>;
  using Point = LayerPoint<Order>;

 public:
  Membrane(SharedFacets<Order> facets, SharedLaw law) : facets_(std::move(facets)), law_(std::move(law)) {}

  std::string_view name() const override { return "shell"; }
  TermDeclaration declaration() const override { return {.rotates_with_body = !law_->law().traits().constant_tangent}; }
  bool has_adjoint() const override { return true; }

  double value(const LocalStage& stage, std::span<const double> q) const override {
    return facets_->integrate([&](const Batch& batch) {
      return [&law = *law_, u0 = Facets::gather(batch, stage.reference()), u = Facets::gather(batch, q)](
                 std::size_t n, const Point& point) {
        const LayerState before = law.state(n, point.axes, Facets::changes(point, u0)),
                         after = law.state(n, point.axes, Facets::changes(point, u));
        return law.psi_change(n, before, after);
      };
    });
  }

  double energy(std::span<const double> q, std::span<const double> /*z*/) const override {
    return facets_->integrate([&](const Batch& batch) {
      return [&law = *law_, u = Facets::gather(batch, q)](std::size_t n, const Point& point) {
        return law.psi(n, law.state(n, point.axes, Facets::changes(point, u)));
      };
    });
  }

  void add_gradient(const LocalStage& /*stage*/, std::span<const double> q, std::span<double> r) const override {
    facets_->add_forces(stresses(q), r);
  }

  void add_forces_per_length(std::span<const double> q, std::span<const double> /*v*/,
                             std::span<std::array<double, 6>> N) const override {
    facets_->add_forces_per_length(stresses(q), q, N);
  }

  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    const bool extrapolates = !stage.previous.empty() && !law_->law().traits().constant_tangent;
    facets_->add_stiffness(
        [&](const Batch& batch) {
          return [&law = *law_, u = Facets::gather(batch, q),
                  before = Facets::gather(batch, extrapolates ? stage.previous : q), projection,
                  extrapolates](std::size_t n, const Point& point) {
            const LayerColumns h = Facets::changes(point, u);
            LayerTangent T;
            const LayerState state = law.tangent(n, point.axes, h, T);
            if (extrapolates) add_extrapolation_error(law, n, point, h, state, Facets::changes(point, before), T);
            if (projection == Projection::positive_semidefinite) make_positive_semidefinite(T);
            return T;
          };
        },
        K);
  }

 private:
  using Stress = std::array<Pack, 3>;  // S_11, S_22, S_12

  auto stresses(std::span<const double> q) const {
    return [this, q](const Batch& batch) {
      return [&law = *law_, u = Facets::gather(batch, q)](std::size_t n, const Point& point) {
        return law.state(n, point.axes, Facets::changes(point, u)).P;
      };
    };
  }

  /// The stress of the layer in its own axes: P_a = sum_b S_ab f_b.
  static Stress stress(const Point& point, const LayerColumns& h, const LayerColumns& P) {
    LayerColumns f = h;
    for (int a = 0; a < 2; ++a) {
      for (int i = 0; i < 3; ++i) f[a][i] += point.axes(a, i);
    }
    const Pack c11 = dot(f[0], f[0]), c22 = dot(f[1], f[1]), c12 = dot(f[0], f[1]);
    const Pack inverse = 1.0 / (c11 * c22 - c12 * c12);
    const auto in_frame = [&](int a, int b) -> Pack { return dot(P[a], f[b]); };
    return {inverse * (c22 * in_frame(0, 0) - c12 * in_frame(0, 1)),
            inverse * (c11 * in_frame(1, 1) - c12 * in_frame(1, 0)),
            inverse * (c11 * in_frame(0, 1) - c12 * in_frame(0, 0))};
  }

  /// Stresses extrapolated along the last step in the place of those at its end (energy/volume/elastic_cells.hpp,
  /// extrapolation_error).
  static void add_extrapolation_error(const PlaneStress& law, std::size_t n, const Point& point, const LayerColumns& h,
                                      const LayerState& at_end, const LayerColumns& before, LayerTangent& T) {
    constexpr double part = 1e-3;
    const auto on_the_way = [&](double s) {
      LayerColumns x = before;
      for (int a = 0; a < 2; ++a) {
        for (int i = 0; i < 3; ++i) x[a][i] += s * (h[a][i] - before[a][i]);
      }
      return stress(point, x, law.state(n, point.axes, x).P);
    };
    const Stress start = on_the_way(0.0), ahead = on_the_way(part), behind = on_the_way(-part),
                 end = stress(point, h, at_end.P);
    std::array<Pack, 3> error;
    for (std::size_t k = 0; k < 3; ++k) {
      error[k] = start[k] + (0.5 / part) * (ahead[k] - behind[k]) - end[k];
      error[k] = select(std::experimental::isfinite(error[k]), error[k], Pack(0.0));
    }
    for (std::size_t i = 0; i < 3; ++i) {
      T[6 * i + i] += error[0];
      T[6 * (3 + i) + 3 + i] += error[1];
      T[6 * i + 3 + i] += error[2];
      T[6 * (3 + i) + i] += error[2];
    }
  }

  SharedFacets<Order> facets_;
  SharedLaw law_;
};

template <int Order>
class MembraneViscosity final : public LayerTerm {
  using Facets = LayerFacets<Order>;
  using Batch = LayerBatch<Order>;
  using Point = LayerPoint<Order>;

 public:
  MembraneViscosity(SharedFacets<Order> facets, const PlaneStress& law, const LayerViscosity& viscosity)
      : facets_(std::move(facets)) {
    // S_v by the components 11, 22, 12 of Edot, of which the last stands for two.
    const double of_trace = viscosity.trace(), twice = 2.0 * viscosity.shear, whole = of_trace + twice;
    const std::array<double, 9> of_shear{whole, of_trace, 0.0, of_trace, whole, 0.0, 0.0, 0.0, 0.5 * twice};
    const LayerColumns at_rest{};
    for (std::size_t n = 0; n < facets_->points().size(); ++n) {
      const Point& point = facets_->points()[n];
      LayerTangent T;
      law.tangent(n, point.axes, at_rest, T);
      // C_abcd = T_ab,cd of the components along the axes.
      const auto along = [&](int b, int c) -> std::array<Pack, 6> {
        std::array<Pack, 6> d{};
        for (std::size_t i = 0; i < 3; ++i) {
          d[3 * c + i] += 0.5 * point.axes(b, static_cast<int>(i));
          d[3 * b + i] += 0.5 * point.axes(c, static_cast<int>(i));
        }
        return d;
      };
      const std::array<std::array<Pack, 6>, 3> modes{along(0, 0), along(1, 1), along(0, 1)};
      Resistance& C = resistances_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t l = 0; l < 3; ++l) {
          C[3 * k + l] = of_shear[3 * k + l];
          for (std::size_t p = 0; p < 6; ++p) {
            for (std::size_t q = 0; q < 6; ++q) {
              C[3 * k + l] += viscosity.damping * (modes[k][p] * (T[6 * p + q] * modes[l][q]));
            }
          }
        }
      }
    }
  }

  std::string_view name() const override { return "shell-viscosity"; }
  TermDeclaration declaration() const override {
    TermDeclaration declaration;
    declaration.is_potential = false;
    declaration.symmetry = Symmetry::unsymmetric;
    declaration.dissipates = true;
    return declaration;
  }
  double value(const LocalStage& /*stage*/, std::span<const double> /*q*/) const override { return 0.0; }

  void add_gradient(const LocalStage& stage, std::span<const double> q, std::span<double> r) const override {
    if (!moves(stage)) return;
    facets_->add_forces(
        [&](const Batch& batch) {
          return [this, at = nodes(batch, stage, q), dt = stage.dt](std::size_t n, const Point& point) {
            return forces(n, motion(point, at, dt));
          };
        },
        r);
  }

  void add_forces_per_length(std::span<const double> q, std::span<const double> v,
                             std::span<std::array<double, 6>> N) const override {
    if (v.empty()) return;
    facets_->add_forces_per_length(
        [&](const Batch& batch) {
          const NodesNow at{Facets::gather(batch, q), Facets::gather(batch, v)};
          return [this, at](std::size_t n, const Point& point) { return forces(n, motion(point, at, 1.0)); };
        },
        q, N);
  }

  // dP_a = S_ab df_b + f_b C_abcd dEdot_cd, dEdot_cd = sym(df_c.v_d + f_c.df_d/dt)
  void add_hessian(const LocalStage& stage, std::span<const double> q, const BlockWriter& K,
                   Projection projection) const override {
    if (!moves(stage)) return;
    const double exact = projection == Projection::none ? 1.0 : 0.0;
    facets_->add_stiffness(
        [&](const Batch& batch) {
          return [this, exact, at = nodes(batch, stage, q), dt = stage.dt](std::size_t n, const Point& point) {
            const Motion m = motion(point, at, dt);
            const Rates S = stress(n, m);
            const Slopes strain = slopes(m.f), rate = slopes(m.v);
            const Resistance& C = resistances_[n];
            LayerTangent T{};
            for (std::size_t k = 0; k < 3; ++k) {
              for (std::size_t l = 0; l < 3; ++l) {
                for (std::size_t p = 0; p < 6; ++p) {
                  for (std::size_t s = 0; s < 6; ++s) {
                    T[6 * p + s] += weight_of(k) * weight_of(l) * strain[k][p] * C[3 * k + l] *
                                    (strain[l][s] / dt + exact * rate[l][s]);
                  }
                }
              }
            }
            for (std::size_t i = 0; i < 3; ++i) {
              T[6 * i + i] += exact * S[0];
              T[6 * (3 + i) + 3 + i] += exact * S[1];
              T[6 * i + 3 + i] += exact * S[2];
              T[6 * (3 + i) + i] += exact * S[2];
            }
            return T;
          };
        },
        K);
  }

  double dissipation(const LocalStage& stage, std::span<const double> q) const override {
    if (!moves(stage)) return 0.0;
    return facets_->integrate([&](const Batch& batch) {
      return [this, at = nodes(batch, stage, q), dt = stage.dt](std::size_t n, const Point& point) {
        const Motion m = motion(point, at, dt);
        const Rates S = stress(n, m), E = rates(m);
        return S[0] * E[0] + (S[1] * E[1] + 2.0 * S[2] * E[2]);
      };
    });
  }

 private:
  using Rates = std::array<Pack, 3>;                  // components 11, 22, 12
  using Resistance = std::array<Pack, 9>;             // beta C of these components [Pa s]
  using Slopes = std::array<std::array<Pack, 6>, 3>;  // of E_11, E_22, E_12 by the columns
  struct Motion {
    LayerColumns f, v;
  };
  struct NodesNow {
    typename Facets::Nodes u, change;
  };
  static bool moves(const LocalStage& stage) { return !stage.q0.empty() && stage.dt > 0.0; }
  /// How often a component stands in a sum over both indices.
  static constexpr double weight_of(std::size_t component) { return component == 2 ? 2.0 : 1.0; }

  static NodesNow nodes(const Batch& batch, const LocalStage& stage, std::span<const double> q) {
    NodesNow now{Facets::gather(batch, q), {}};
    const auto before = Facets::gather(batch, stage.q0);
    for (std::size_t a = 0; a < now.u.size(); ++a) {
      for (std::size_t i = 0; i < 3; ++i) now.change[a][i] = now.u[a][i] - before[a][i];
    }
    return now;
  }
  static Motion motion(const Point& point, const NodesNow& at, double dt) {
    Motion m{Facets::changes(point, at.u), Facets::columns(point, at.change)};
    for (int a = 0; a < 2; ++a) {
      for (int i = 0; i < 3; ++i) {
        m.f[a][i] += point.axes(a, i);
        m.v[a][i] /= dt;
      }
    }
    return m;
  }
  static Rates rates(const Motion& m) {
    return {dot(m.f[0], m.v[0]), dot(m.f[1], m.v[1]), 0.5 * (dot(m.f[0], m.v[1]) + dot(m.f[1], m.v[0]))};
  }
  static Slopes slopes(const LayerColumns& f) {
    Slopes result{};
    for (std::size_t i = 0; i < 3; ++i) {
      result[0][i] = f[0][i];
      result[1][3 + i] = f[1][i];
      result[2][i] = 0.5 * f[1][i];
      result[2][3 + i] = 0.5 * f[0][i];
    }
    return result;
  }
  /// P_a = S_ab f_b.
  LayerColumns forces(std::size_t n, const Motion& m) const {
    const Rates S = stress(n, m);
    LayerColumns P;
    for (int i = 0; i < 3; ++i) {
      P[0][i] = S[0] * m.f[0][i] + S[2] * m.f[1][i];
      P[1][i] = S[1] * m.f[1][i] + S[2] * m.f[0][i];
    }
    return P;
  }
  Rates stress(std::size_t n, const Motion& m) const {
    const Rates E = rates(m);
    const Resistance& C = resistances_[n];
    Rates S;
    for (std::size_t k = 0; k < 3; ++k) S[k] = C[3 * k] * E[0] + (C[3 * k + 1] * E[1] + 2.0 * C[3 * k + 2] * E[2]);
    return S;
  }

  SharedFacets<Order> facets_;
  std::vector<Resistance> resistances_;  // of each pack of points
};

std::unique_ptr<LawField> law_field(const LayerMaterial& material, std::size_t num_packs,
                                    const std::function<std::array<double, 3>(std::size_t, int)>& place) {
  if (!material.law_at) return make_law_field(material.law);
  return make_law_field(material.law, num_packs,
                        [&](std::size_t n, int lane) { return material.law_at(place(n, lane)); });
}

template <int Order>
MembraneTerms make_membrane_of(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                               const LayerShape& shape, const LayerMaterial& material) {
  const int degree = elastic_quadrature_degree(material.law.traits(), Order);
  const auto packed = std::make_shared<const LayerFacets<Order>>(layout, pattern, facets, shape, degree);
  const auto law =
      std::make_shared<const PlaneStress>(law_field(material, packed->points().size(), [&](std::size_t n, int lane) {
        return packed->points()[n].places[static_cast<std::size_t>(lane)];
      }));
  MembraneTerms terms{std::make_unique<Membrane<Order>>(packed, law), nullptr};
  if (material.viscosity.is_any()) {
    terms.viscosity = std::make_unique<MembraneViscosity<Order>>(packed, *law, material.viscosity);
  }
  return terms;
}

/// int N_a N_b dA of a facet at [n a + b] [m^2].
template <int Order>
std::vector<double> products_of_facet(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  static const auto rule = simplex_rule<2>(4 * Order - 2);
  const std::size_t n = nodes.size();
  std::vector<double> products(n * n, 0.0);
  for (int k = 0; k < rule.size(); ++k) {
    const auto N = Triangle<Order>::values(rule.points[k]);
    const auto dN = Triangle<Order>::gradients(rule.points[k]);
    Vector3<double> X_xi{}, X_eta{};
    for (std::size_t a = 0; a < n; ++a) {
      const Vector3<double> X = layout.position(nodes[a]);
      X_xi = X_xi + dN[a][0] * X;
      X_eta = X_eta + dN[a][1] * X;
    }
    const double area = rule.weights[k] * norm(cross(X_xi, X_eta));
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) products[n * a + b] += area * N[a] * N[b];
    }
  }
  return products;
}

std::vector<double> products_of_facet(const NodeLayout& layout, std::span<const PetscInt> nodes) {
  return layout.order == 1 ? products_of_facet<1>(layout, nodes) : products_of_facet<2>(layout, nodes);
}

}  // namespace

MembraneTerms make_membrane(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                            const LayerShape& shape, const LayerMaterial& material) {
  return layout.order == 1 ? make_membrane_of<1>(layout, pattern, facets, shape, material)
                           : make_membrane_of<2>(layout, pattern, facets, shape, material);
}

std::vector<double> lumped_masses_of_layer(const NodeLayout& layout, const FacetList& facets, double mass_per_area) {
  std::vector<double> masses;
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const std::vector<double> products = products_of_facet(layout, facets.nodes_of(f));
    const auto n = static_cast<std::size_t>(facets.nodes_per_facet);
    double area = 0.0, trace = 0.0;
    for (std::size_t k = 0; k < products.size(); ++k) area += products[k];
    for (std::size_t a = 0; a < n; ++a) trace += products[n * a + a];
    for (std::size_t a = 0; a < n; ++a) masses.push_back(mass_per_area * area * products[n * a + a] / trace);
  }
  return masses;
}

void add_masses_of_layer(const NodeLayout& layout, const BlockPattern& pattern, const FacetList& facets,
                         double mass_per_area, Mass kind, MassMatrix& mass) {
  const auto n = static_cast<std::size_t>(facets.nodes_per_facet);
  const auto lumped =
      kind == Mass::lumped ? lumped_masses_of_layer(layout, facets, mass_per_area) : std::vector<double>{};
  for (PetscInt f = 0; f < facets.size(); ++f) {
    const auto nodes = facets.nodes_of(f);
    const auto products = kind == Mass::lumped ? std::vector<double>{} : products_of_facet(layout, nodes);
    for (std::size_t a = 0; a < n; ++a) {
      if (nodes[a] >= layout.num_owned_nodes) continue;
      if (kind == Mass::lumped) {
        mass.add(pattern.block(nodes[a], nodes[a]), lumped[static_cast<std::size_t>(f) * n + a]);
        continue;
      }
      for (std::size_t b = 0; b < n; ++b) {
        mass.add(pattern.block(nodes[a], nodes[b]), mass_per_area * products[n * a + b]);
      }
    }
  }
}

}  // namespace pliant
