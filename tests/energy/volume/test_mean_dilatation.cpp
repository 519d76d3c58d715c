// Mean dilatation against its definition, in four times the digits.
#include "energy/reference.hpp"
#include "energy/solid.hpp"

#include <ostream>

namespace pliant::test_mean_dilatation {
namespace {

using test::BodySpec;
using test::Dilatation;
using test::Point;
using test::Quad;
using test::Scratch;
using test::Shape;
using test::Solid;

const MPI_Comm comm = MPI_COMM_WORLD;

struct Case {
  ElasticLawSpec law;
  BodySpec body;
};

std::string name_of(const Case& c) {
  return test::name_of(c.law) + test::name_of(c.body);
}
std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << name_of(c);
}

std::vector<Case> every_case() {
  std::vector<Case> cases;
  for (const BodySpec body : {BodySpec{2, Shape::jittered, 2}, BodySpec{2, Shape::curved, 2}}) {
    for (const auto& law : test::every_law(1e9, 0.49)) {
      if (!test::is_linear(law)) cases.push_back({law, body});
    }
  }
  return cases;
}

/// The quadrature points of a cell: dN/dX, weights, and F under nodal displacements u.
struct QuadCell {
  std::vector<std::array<std::array<Quad, 3>, 10>> dN;
  std::vector<Quad> weights;
  std::vector<Tensor3<Quad>> F;

  QuadCell(const NodeLayout& layout, PetscInt cell, int degree, const std::vector<double>& u) {
    const auto nodes = layout.nodes_of_cell(cell);
    const auto rule = simplex_rule<3>(degree);
    for (int q = 0; q < rule.size(); ++q) {
      const auto reference = Tet<2>::gradients(rule.points[q]);
      Tensor3<Quad> X{};
      for (int a = 0; a < 10; ++a) {
        for (int i = 0; i < 9; ++i) X.a[i] += Quad(layout.coordinates[3 * nodes[a] + i / 3]) * reference[a][i % 3];
      }
      const Tensor3<Quad> inverse = Quad(1 / det(X)) * transpose(cofactor(X));
      weights.push_back(rule.weights[q] * det(X));
      auto& gradients = dN.emplace_back();
      auto& gradient = F.emplace_back(identity<Quad>());
      for (int a = 0; a < 10; ++a) {
        for (int k = 0; k < 3; ++k) {
          for (int l = 0; l < 3; ++l) gradients[a][k] += Quad(reference[a][l]) * inverse(l, k);
          for (int i = 0; i < 3; ++i) gradient(i, k) += Quad(u[3 * nodes[a] + i]) * gradients[a][k];
        }
      }
    }
  }

  /// The mean of J.
  Quad theta() const {
    Quad volume = 0, current = 0;
    for (std::size_t q = 0; q < F.size(); ++q) {
      volume += weights[q];
      current += weights[q] * det(F[q]);
    }
    return current / volume;
  }
  /// Fbar - I.
  Tensor3<Quad> H(std::size_t q) const {
    return add_to_diagonal(power_reference(theta() / det(F[q]), Quad(1) / 3) * F[q], -1);
  }
  static Quad power_reference(Quad x, Quad exponent) { return testing_states::power_reference(x, exponent); }
};

class MeanDilatation : public ::testing::TestWithParam<Case> {
 protected:
  int degree() const { return elastic_quadrature_degree(GetParam().law.traits(), 2); }

  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  Solid solid_{comm, file_, 2, degree()};
  std::unique_ptr<ElasticTerm> term_ = solid_.elastic(GetParam().law, Dilatation::mean);
};

INSTANTIATE_TEST_SUITE_P(Registry, MeanDilatation, ::testing::ValuesIn(every_case()),
                         [](const auto& of) { return name_of(of.param); });

TEST_P(MeanDilatation, EnergyIsTheLawsAtTheMeanVolumeRatio) {
  const auto u = test::local_values(solid_.vector(test::strained).get());
  Quad expected = 0;
  double pointwise_volume = 0.0;
  for (PetscInt c = 0; c < solid_.layout().num_owned_cells; ++c) {
    const QuadCell cell(solid_.layout(), c, degree(), u);
    for (std::size_t q = 0; q < cell.F.size(); ++q) {
      expected += cell.weights[q] * testing_states::textbook_psi(instantiate(GetParam().law), cell.H(q));
      const auto deviation = static_cast<double>(det(cell.F[q]) - cell.theta());
      pointwise_volume = std::max(pointwise_volume, std::abs(deviation));
    }
  }
  const double total = sum(comm, static_cast<double>(expected));
  EXPECT_GT(maximum(comm, pointwise_volume), 1e-2);  // the mean differs from the points
  EXPECT_NEAR(sum(comm, term_->energy(u, {})), total, 1e-13 * total);
}

TEST_P(MeanDilatation, ForcesOfStrainsOf1e8KeepTheirDigits) {
  const auto q = solid_.vector([](const Point& x) {
    return Point{1e-8 * (x[0] * x[1] + 0.1 * test::rough(x, 0, 1)), 1e-8 * (x[2] * x[2] - x[0]),
                 1e-8 * (x[1] + 0.3 * x[2] + 0.1 * test::rough(x, 2, 1))};
  });
  const auto u = test::local_values(q.get());
  const LocalStage stage{0.0, 1.0, 1.0, {}, {}, {}};
  std::vector<double> r(u.size(), 0.0);
  term_->add_gradient(stage, u, r);
  std::vector<Quad> expected(u.size(), Quad(0));
  for (PetscInt c = 0; c < solid_.layout().num_local_cells; ++c) {
    const QuadCell cell(solid_.layout(), c, degree(), u);
    const auto nodes = solid_.layout().nodes_of_cell(c);
    const Quad theta = cell.theta();
    std::vector<Tensor3<Quad>> Pb;
    Quad volume = 0, pressure = 0;
    for (std::size_t k = 0; k < cell.F.size(); ++k) {
      const auto H = cell.H(k);
      Pb.push_back(testing_states::textbook_P(instantiate(GetParam().law), H));
      volume += cell.weights[k];
      pressure += cell.weights[k] * dot(Pb[k], add_to_diagonal(H, 1)) / (3 * theta);
    }
    for (std::size_t k = 0; k < cell.F.size(); ++k) {
      const auto &F = cell.F[k], H = cell.H(k);
      const Quad J = det(F), scale = cell.power_reference(theta / J, Quad(1) / 3);
      const Quad tau = dot(Pb[k], add_to_diagonal(H, 1));
      const auto P = scale * Pb[k] + (pressure / volume - tau / (3 * J)) * cofactor(F);
      for (int a = 0; a < 10; ++a) {
        for (int i = 0; i < 9; ++i) expected[3 * nodes[a] + i / 3] += cell.weights[k] * P.a[i] * cell.dN[k][a][i % 3];
      }
    }
  }
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < 3 * static_cast<std::size_t>(solid_.layout().num_owned_nodes); ++i) {
    error += std::pow(static_cast<double>(r[i] - expected[i]), 2);
    size += std::pow(static_cast<double>(expected[i]), 2);
  }
  error = std::sqrt(sum(comm, error));
  size = std::sqrt(sum(comm, size));
  ASSERT_GT(size, 0.1);  // 1e9 Pa at strains of 1e-8
  // The forces of the volume are 50 times those that are left of them where nodes balance.
  EXPECT_LE(error, 1e-13 * size);
}

}  // namespace
}  // namespace pliant::test_mean_dilatation
