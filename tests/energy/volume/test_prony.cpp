// Finite linear viscoelasticity: what its branches store and lose, and where it is another law's.
#include "energy/reference.hpp"
#include "energy/volume/prony.hpp"
#include "energy/volume/viscous_body.hpp"

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

class BranchStates : public ::testing::TestWithParam<std::size_t> {
 protected:
  ElasticLawSpec spec_ = typical_law(GetParam());
  std::unique_ptr<LawField> law_ = make_law_field(spec_);
  bool is_small_strain_ = spec_.traits().constant_tangent;

  Tensor3<Pack> strain(const Tensor3<Pack>& H) const { return is_small_strain_ ? small_strain(H) : green_lagrange(H); }
  Tensor3<Pack> stress(const Tensor3<Pack>& H) const {
    const Tensor3<Pack> F = add_to_diagonal(H, 1.0), P = law_->P(0, H);
    return is_small_strain_ ? P : matmul((1.0 / det(F)) * transpose(cofactor(F)), P);
  }
};

INSTANTIATE_TEST_SUITE_P(Registry, BranchStates, ::testing::Range<std::size_t>(0, elastic_laws().size()),
                         [](const auto& of) {
                           std::string name(elastic_laws()[of.param].name);
                           std::erase(name, '-');
                           return name;
                         });

// Strains at which every law of the table is convex in E: none where a body swells until ln J > mu / lambda.
TEST_P(BranchStates, AreTheDistanceFromTheStrainOfTheForgottenStress) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Tensor3<Pack> H = packed(random_matrix(seed, 0.01)), at = packed(random_matrix(seed + 100, 0.01));
    const Tensor3<Pack> A = stress(at), elongation = strain(H) - strain(at);
    const BranchState state = branch_state(*law_, 0, H, A);
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
  const BranchState state = branch_state(*law_, 0, H, stress(H));
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

TEST_F(PronySeries, PowerIsStoredOrDissipated) {
  PronyBody body(comm, file_, [](const Solid& s) { return s.prony({{0.5, 0.05}, {1.5, 0.3}}, "neo-hookean"); });
  const auto gap = [&](double h) {
    const auto r = body.after_two_stages(h);
    EXPECT_GT(r.lost, 0.0);
    return (r.power - r.lost - r.stored) / r.power;
  };
  const double coarse = gap(2e-4), fine = gap(1e-4);
  EXPECT_LT(std::abs(coarse), 0.02);
  EXPECT_NEAR(std::log2(coarse / fine), 1.0, 0.02);
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
