// Finite linear viscoelasticity: what its branches store and lose, and where it is another law's.
#include "energy/reference.hpp"
#include "energy/volume/branch_law.hpp"
#include "energy/volume/prony.hpp"
#include "energy/volume/viscous_body.hpp"
#include "material/volume_split.hpp"

#include <ostream>

namespace pliant::test_prony {
namespace {

using test::at_time;
using test::BodySpec;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;
using testing_states::random_matrix;

const MPI_Comm comm = MPI_COMM_WORLD;
const BodySpec spec{2, Shape::jittered, 2};

Tensor3<Pack> packed(const Tensor3<double>& A) {
  return make_tensor([&](int i, int j) -> Pack { return A(i, j); });
}

using Strain = BranchLaw::Strain;

struct Followed {
  std::string name;
  ElasticLawSpec law;
};
void PrintTo(const Followed& followed, std::ostream* out) {  // NOLINT(readability-identifier-naming)
  *out << followed.name;
}

/// Every law, and what is left of it without its volumetric part where a branch may follow that.
std::vector<Followed> every_law() {
  std::vector<Followed> laws;
  for (std::size_t row = 0; row < elastic_laws().size(); ++row) {
    const ElasticLawSpec whole = typical_law(row);
    laws.push_back({test::name_of(whole), whole});
    const auto split = split_volume(whole);
    if (split && can_relax(split->rest)) laws.push_back({test::name_of(whole) + "WithoutVolume", split->rest});
  }
  return laws;
}

class BranchStates : public ::testing::TestWithParam<Followed> {
 protected:
  std::unique_ptr<LawField> law_ = make_law_field(GetParam().law);
  BranchLaw branch_{*law_};

  /// The definitions, in the digits that they have.
  Tensor3<Pack> strain(const Tensor3<Pack>& H) const {
    if (branch_.strain_measure() == Strain::small) return small_strain(H);
    if (branch_.strain_measure() == Strain::green_lagrange) return green_lagrange(H);
    const Tensor3<Pack> F = add_to_diagonal(H, 1.0);
    return 0.5 * add_to_diagonal(per_volume(F, -2.0 / 3) * matmul(transpose(F), F), -1.0);
  }
  Tensor3<Pack> stress(const Tensor3<Pack>& H) const {
    const Tensor3<Pack> F = add_to_diagonal(H, 1.0), P = law_->P(0, H);
    if (branch_.strain_measure() == Strain::small) return P;
    const Tensor3<Pack> S = matmul((1.0 / det(F)) * transpose(cofactor(F)), P);
    return branch_.strain_measure() == Strain::isochoric ? per_volume(F, 2.0 / 3) * S : S;
  }

 private:
  static Pack per_volume(const Tensor3<Pack>& F, double power) {
    return Pack([&](auto lane) { return std::pow(static_cast<double>(det(F)[lane]), power); });
  }
};

INSTANTIATE_TEST_SUITE_P(Registry, BranchStates, ::testing::ValuesIn(every_law()),
                         [](const auto& of) { return of.param.name; });

TEST_P(BranchStates, MeasureStrainAsDefined) {
  const Tensor3<Pack> H = packed(random_matrix(5, 0.1)), dH = packed(random_matrix(6, 0.05));
  const auto expect_near = [](const Tensor3<Pack>& A, const Tensor3<Pack>& B, double within) {
    const Tensor3<Pack> error = A - B;
    EXPECT_LE(std::sqrt(dot(error, error)[0]), within * std::sqrt(dot(B, B)[0]));
  };
  expect_near(branch_.strain(H), strain(H), 1e-13);
  expect_near(branch_.stress(0, H), stress(H), 1e-13);
  expect_near(branch_.strain_change(H, dH), strain(H + dH) - strain(H), 1e-12);
}

TEST_P(BranchStates, ForceAndStiffnessAreDerivatives) {
  const Tensor3<Pack> H = packed(random_matrix(7, 0.1)), dH = packed(random_matrix(8, 1.0));
  const Tensor3<Pack> A = small_strain(packed(random_matrix(9, 1.0)));
  constexpr double h = 1e-3;
  const auto along = [&](double s) { return H + s * dH; };
  const auto difference = [&](const auto& f) {  // of fourth order
    return (1.0 / (12.0 * h)) * (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h)));
  };
  const Pack slope = difference([&](double s) -> Pack { return dot(A, branch_.strain(along(s))); });
  EXPECT_NEAR(dot(branch_.force(H, A), dH)[0], slope[0], 1e-9 * std::abs(slope[0]));
  Tangent<Pack> K{};
  branch_.subtract_stiffness(H, A, K);
  const Tensor3<Pack> change = difference([&](double s) -> Tensor3<Pack> { return branch_.force(along(s), A); });
  Tensor3<Pack> product{};
  for (int p = 0; p < 9; ++p) {
    for (int q = 0; q < 9; ++q) product.a[p] -= K[9 * p + q] * dH.a[q];
  }
  const Tensor3<Pack> error = product - change;
  EXPECT_LE(std::sqrt(dot(error, error)[0]), 1e-9 * (1.0 + std::sqrt(dot(change, change)[0])));
}

// Strains at which every law of the table is convex in E: none where a body swells until ln J > mu / lambda.
TEST_P(BranchStates, AreTheDistanceFromTheStrainOfTheForgottenStress) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Tensor3<Pack> H = packed(random_matrix(seed, 0.01)), at = packed(random_matrix(seed + 100, 0.01));
    const Tensor3<Pack> A = stress(at), elongation = strain(H) - strain(at);
    const BranchState state = branch_.state(0, H, A);
    const double size = std::sqrt(dot(elongation, elongation)[0]);
    const Tensor3<Pack> error = state.elongation - elongation;
    EXPECT_LE(std::sqrt(dot(error, error)[0]), 1e-12 * size);
    const double energy = (law_->psi(0, H) - law_->psi(0, at) - dot(A, elongation))[0];
    EXPECT_NEAR(state.energy[0], energy, 1e-12 * law_->psi(0, H)[0]);
    EXPECT_GT(state.energy[0], 0.0);
    EXPECT_GT(dot(stress(H) - A, state.elongation)[0], 0.0);
  }
}

TEST_P(BranchStates, HoldNothingInEquilibrium) {
  const Tensor3<Pack> H = packed(random_matrix(3, 0.1));
  const BranchState state = branch_.state(0, H, stress(H));
  EXPECT_LE(std::abs(state.energy[0]), 1e-14 * law_->psi(0, H)[0]);
  EXPECT_LE(dot(state.elongation, state.elongation)[0], 1e-26);
}

struct PronyBody {
  PronyBody(MPI_Comm on, const std::string& file, const std::function<std::unique_ptr<EnergyTerm>(const Solid&)>& make)
      : solid(on, file, spec.order, 4),
        term(make(solid)),
        potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed()) {}

  struct Result {
    double force, change, power, lost, stored;
  };
  /// At the end of the second of two stages of the length h that end at time 0.
  Result after_two_stages(double h) {
    TestStage first(solid, 0.0, h, at_time(-2.0 * h)), second(solid, 0.0, h, at_time(-h));
    first.z0 = potential.make_internal();
    first.point.z0 = first.z0.get();
    check(VecSet(first.z0.get(), 0.0));
    second.z0 = potential.make_internal();
    potential.internal_variables().end_stage(first.point, second.q0.get(), second.z0.get());
    second.point.z0 = second.z0.get();
    const Handle<Vec> q = solid.vector(at_time(0.0)), z = potential.make_internal();
    potential.internal_variables().end_stage(second.point, q.get(), z.get());
    potential.begin_stage(second.point);
    const Handle<Vec> r = potential.make_vector(), v = test::moved(q.get(), -1.0, second.q0.get());
    check(VecScale(v.get(), 1.0 / h));
    const double change = potential.value(q.get());
    const TermPower power = potential.accounts().powers(q.get(), v.get(), r.get())[0];
    const double before = potential.accounts().energies({}, second.q0.get(), second.z0.get())[0];
    return {test::norm(r.get()), change, -power.exerted, power.dissipated,
            (potential.accounts().energies({}, q.get(), z.get())[0] - before) / h};
  }

  Solid solid;
  std::unique_ptr<EnergyTerm> term;
  IncrementalPotential potential;
};

class PronySeries : public ::testing::Test {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) { test::write_body(f, spec); });
};

// S_e is linear in E then, and A the stress of the strain that the dashpot has.
TEST_F(PronySeries, OnSaintVenantKirchhoffIsMaxwell) {
  constexpr double g = 0.7, tau = 0.1;
  const Lame c = lame(test::prony_modulus, 0.3);
  PronyBody prony(comm, file_, [=](const Solid& s) { return s.prony({{g, tau}}, "saint-venant-kirchhoff"); });
  PronyBody maxwell(comm, file_, [=](const Solid& s) {
    return s.viscous(Maxwell{g * c.mu, g * bulk_modulus(c), tau});
  });
  const auto a = prony.after_two_stages(0.05), b = maxwell.after_two_stages(0.05);
  EXPECT_NEAR(a.force, b.force, 1e-12 * b.force);
  EXPECT_NEAR(a.change, b.change, 1e-12 * std::abs(b.change));
  EXPECT_NEAR(a.power, b.power, 1e-12 * std::abs(b.power));
  EXPECT_NEAR(a.lost, b.lost, 1e-12 * b.lost);
  EXPECT_NEAR(a.stored, b.stored, 1e-11 * std::abs(b.stored));
}

/// What is not stored and not lost falls with the length of the stages.
void expect_power_to_be_stored_or_lost(PronyBody& body) {
  const auto gap = [&](double h) {
    const auto r = body.after_two_stages(h);
    EXPECT_GT(r.lost, 0.0);
    return (r.power - r.lost - r.stored) / r.power;
  };
  const double coarse = gap(2e-4), fine = gap(1e-4);
  EXPECT_LT(std::abs(coarse), 0.02);
  EXPECT_NEAR(std::log2(coarse / fine), 1.0, 0.02);
}

TEST_F(PronySeries, PowerIsStoredOrDissipated) {
  PronyBody body(comm, file_, [](const Solid& s) { return s.prony({{0.5, 0.05}, {1.5, 0.3}}, "neo-hookean"); });
  expect_power_to_be_stored_or_lost(body);
}

// Large strains, and laws that are not convex in the strain: the branch is free of stress at the minimum.
TEST_F(PronySeries, IsochoricBranchesStoreAndLose) {
  for (const char* name : {"neo-hookean-isochoric", "mooney-rivlin", "gent", "ogden"}) {
    const auto law = make_law_field(test::without_volume(name));
    const BranchLaw branch(*law);
    ASSERT_EQ(branch.strain_measure(), Strain::isochoric);
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Tensor3<Pack> H = packed(random_matrix(seed, 0.3));
      // Half of the stress of another state is forgotten.
      const Tensor3<Pack> A = 0.5 * branch.stress(0, packed(random_matrix(seed + 100, 0.3)));
      const BranchState state = branch.state(0, H, A);
      EXPECT_GT(state.energy[0], 0.0) << name;
      EXPECT_GT(dot(branch.stress(0, H) - A, state.elongation)[0], 0.0) << name;
    }
  }
}

TEST_F(PronySeries, PowerOfIsochoricBranchesIsStoredOrDissipated) {
  const auto rest = test::without_volume("mooney-rivlin");
  PronyBody body(comm, file_, [&](const Solid& s) { return s.prony({{0.5, 0.05}, {1.5, 0.3}}, rest); });
  expect_power_to_be_stored_or_lost(body);
}

TEST_F(PronySeries, NothingDependsOnTheNumberOfRanks) {
  const auto make = [](const Solid& s) { return s.prony({{0.5, 0.05}, {1.5, 0.3}}, "neo-hookean"); };
  const auto mine = PronyBody(comm, file_, make).after_two_stages(0.05);
  const auto alone = PronyBody(MPI_COMM_SELF, file_, make).after_two_stages(0.05);
  ASSERT_GT(alone.force, 1.0);
  EXPECT_NEAR(mine.force, alone.force, 1e-12 * alone.force);
  EXPECT_NEAR(mine.change, alone.change, 1e-12 * std::abs(alone.change));
  EXPECT_NEAR(mine.lost, alone.lost, 1e-11 * alone.lost);
  EXPECT_NEAR(mine.stored, alone.stored, 1e-11 * std::abs(alone.stored));
}

}  // namespace
}  // namespace pliant::test_prony
