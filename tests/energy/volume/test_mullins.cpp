// Softening of a body: forces, stiffness, what it stores and loses, on both sides of the largest strain of the past.
#include "energy/solid.hpp"
#include "energy/volume/internal_keys.hpp"
#include "energy/volume/mullins.hpp"
#include "material/volume_split.hpp"

#include <map>
#include <ostream>

namespace pliant::test_mullins {
namespace {

using test::BodySpec;
using test::Point;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

struct Softened {
  std::string_view law;
  BodySpec body;
};
std::ostream& operator<<(std::ostream& out, const Softened& c) {
  return out << c.law << c.body;
}

std::unique_ptr<EnergyTerm> make_term(const Solid& solid, std::string_view law) {
  const ElasticLawSpec rest = test::without_volume(law);
  std::shared_ptr<const LawField> distortion = make_law_field(rest);
  const Mullins softening{1.6, 10.0, 0.3};
  const PetscInt num_owned = solid.layout().num_owned_nodes;
  if (const auto* linear = std::get_if<CellGroups<1>>(&solid.groups()))
    return make_mullins_term<1>(softening, distortion, *linear, 0, num_owned);
  return make_mullins_term<2>(softening, distortion, std::get<CellGroups<2>>(solid.groups()), 0, num_owned);
}

test::Field scaled(double size) {
  return [size](const Point& x) {
    const Point u = test::strained(x);
    return Point{size * u[0], size * u[1], size * u[2]};
  };
}

/// A body that has been strained as far as test::strained, and is unloaded in part at the start of the stage.
struct SoftBody {
  SoftBody(MPI_Comm on, const std::string& file, const Softened& of)
      : solid(on, file, of.body.order, 2 * (of.body.order - 1)),
        term(make_term(solid, of.law)),
        potential(solid.layout(), solid.pattern(), {term.get()}, solid.nothing_prescribed()),
        past(solid.vector(scaled(1.0))),
        start(solid.vector(scaled(0.9))),
        z(potential.make_internal()) {
    potential.internal_variables().complete_step(nullptr, past.get(), z.get());
    stage.point.accepted_z = z.get();
    stage.point.accepted = start.get();
    potential.begin_stage(stage.point);
  }
  Handle<Vec> gradient(Vec q) {
    Handle<Vec> r = potential.make_vector();
    potential.gradient(q, r.get());
    return r;
  }
  /// The internal variables after a step that ends at q.
  Handle<Vec> after(Vec q) {
    Handle<Vec> result = potential.make_internal();
    potential.internal_variables().complete_step(z.get(), q, result.get());
    return result;
  }
  double stored(Vec q, Vec at) { return potential.accounts().energies({}, q, at)[0]; }
  double lost(Vec at) { return potential.accounts().dissipated(at)[0]; }

  Solid solid;
  std::unique_ptr<EnergyTerm> term;
  IncrementalPotential potential;
  Handle<Vec> past, start, z;
  TestStage stage{solid, 0.7, 0.05, test::rough_field(0.01, 3)};
};

class Mullins : public ::testing::TestWithParam<Softened> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [&](const std::string& f) { test::write_body(f, GetParam().body); });
  SoftBody body_{comm, file_, GetParam()};
  Handle<Vec> below_ = body_.solid.vector(scaled(0.7)), beyond_ = body_.solid.vector(scaled(1.3));
  Handle<Vec> direction_ = body_.solid.vector(test::rough_field(0.05, 11));
};

INSTANTIATE_TEST_SUITE_P(Bodies, Mullins,
                         ::testing::Values(Softened{"neo-hookean-isochoric", {1, Shape::jittered, 2}},
                                           Softened{"ogden", {2, Shape::curved, 2}},
                                           Softened{"neo-hookean", {2, Shape::jittered, 2}}),
                         [](const auto& of) {
                           std::string name(of.param.law);
                           std::erase(name, '-');
                           return name + test::name_of(of.param.body);
                         });

constexpr double h = 1e-3;

TEST_P(Mullins, ForcesAndStiffnessBelowTheLargestStrainAreDerivatives) {
  for (const Vec q : {below_.get(), body_.start.get()}) {
    ASSERT_EQ(test::distance(body_.after(q).get(), body_.z.get()), 0.0);  // no point reaches its largest energy
    const auto at = [&](double s) { return test::moved(q, s, direction_.get()); };
    const auto difference = [&](const auto& f) { return 8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h)); };
    const auto g = body_.gradient(q);
    const double expected = difference([&](double s) { return body_.potential.value(at(s).get()); }) / (12.0 * h);
    ASSERT_GT(std::abs(expected), 1e-4 * test::norm(g.get()) * test::norm(direction_.get()));
    EXPECT_NEAR(test::dot(g.get(), direction_.get()), expected,
                1e-9 * test::norm(g.get()) * test::norm(direction_.get()));

    const Handle<Mat> K = body_.potential.make_hessian();
    body_.potential.hessian(q, K.get(), Projection::none);
    const Handle<Vec> Kd = body_.potential.make_vector(), slope = body_.potential.make_vector();
    check(MatMult(K.get(), direction_.get(), Kd.get()));
    for (const auto& [s, weight] : {std::pair{h, 8.0}, {-h, -8.0}, {2.0 * h, -1.0}, {-2.0 * h, 1.0}}) {
      check(VecAXPY(slope.get(), weight / (12.0 * h), body_.gradient(at(s).get()).get()));
    }
    ASSERT_GT(test::norm(Kd.get()), 1e-3);
    EXPECT_LE(test::distance(Kd.get(), slope.get()), 1e-7 * test::norm(Kd.get()));
  }
}

TEST_P(Mullins, NothingIsTakenFromTheLawBeyondTheLargestStrain) {
  EXPECT_EQ(test::norm(body_.gradient(beyond_.get()).get()), 0.0);
  const Handle<Mat> K = body_.potential.make_hessian();
  body_.potential.hessian(beyond_.get(), K.get(), Projection::none);
  PetscReal size = 1.0;
  check(MatNorm(K.get(), NORM_FROBENIUS, &size));
  EXPECT_EQ(size, 0.0);
}

TEST_P(Mullins, TheProjectedStiffnessIsSemidefinite) {
  const Handle<Mat> K = body_.potential.make_hessian();
  const Handle<Vec> Kd = body_.potential.make_vector();
  bool is_indefinite = false;
  for (const Projection projection : {Projection::none, Projection::positive_semidefinite}) {
    body_.potential.hessian(below_.get(), K.get(), projection);
    for (int seed = 0; seed < 5; ++seed) {
      const Handle<Vec> d = body_.solid.vector(test::rough_field(1.0, 20 + seed));
      check(MatMult(K.get(), d.get(), Kd.get()));
      const double power = test::dot(d.get(), Kd.get());
      if (projection == Projection::none)
        is_indefinite = is_indefinite || power < 0.0;
      else
        EXPECT_GE(power, -1e-12 * test::norm(d.get()) * test::norm(Kd.get()));
    }
  }
  EXPECT_TRUE(is_indefinite);
}

// Small changes of a strained body's energy, as near the end of Newton's iteration.
TEST_P(Mullins, SmallChangesKeepTheirDigits) {
  const auto g = body_.gradient(body_.start.get());
  const double small = 1e-9, expected = small * test::dot(g.get(), direction_.get());
  const auto q = test::moved(body_.start.get(), small, direction_.get());
  EXPECT_EQ(body_.potential.value(body_.start.get()), 0.0);
  EXPECT_NEAR(body_.potential.value(q.get()), expected, 1e-6 * std::abs(expected));
}

// What the forces do is what the body stores and what it loses, on both sides and across.
TEST_P(Mullins, StoredAndLostEnergiesAddUpToTheWork) {
  const double stored = body_.stored(body_.start.get(), body_.z.get()), lost = body_.lost(body_.z.get());
  EXPECT_GT(lost, 0.0);
  EXPECT_LT(stored, 0.0);  // less than the law
  for (const Vec q : {below_.get(), body_.past.get(), beyond_.get()}) {
    const Handle<Vec> z = body_.after(q);
    const double work = body_.potential.value(q);
    EXPECT_NEAR(body_.stored(q, z.get()) - stored + body_.lost(z.get()) - lost, work, 1e-12 * lost);
    if (q == beyond_.get()) {
      EXPECT_GT(body_.lost(z.get()), 1.2 * lost);
    } else {
      EXPECT_EQ(body_.lost(z.get()), lost);
    }
  }
}

TEST_P(Mullins, NothingDependsOnTheNumberOfRanks) {
  SoftBody whole(MPI_COMM_SELF, file_, GetParam());
  const Handle<Vec> q = whole.solid.vector(scaled(0.7));
  EXPECT_NEAR(body_.potential.value(below_.get()), whole.potential.value(q.get()), 1e-13 * whole.lost(whole.z.get()));
  EXPECT_NEAR(body_.lost(body_.z.get()), whole.lost(whole.z.get()), 1e-13 * whole.lost(whole.z.get()));
  const auto r = whole.gradient(q.get());
  EXPECT_NEAR(test::norm(body_.gradient(below_.get()).get()), test::norm(r.get()), 1e-13 * test::norm(r.get()));

  // The largest energies are found again under their keys, next to tensors too.
  const auto prony = body_.solid.prony({{0.3, 0.1}}, "neo-hookean"),
             of_whole = whole.solid.prony({{0.3, 0.1}}, "neo-hookean");
  const std::vector<const EnergyTerm*> terms{prony.get(), body_.term.get()}, all{of_whole.get(), whole.term.get()};
  ASSERT_EQ(internal_components(terms), 1);
  const auto keys = internal_keys(body_.solid.layout(), terms),
             keys_of_whole = internal_keys(whole.solid.layout(), all);
  ASSERT_EQ(keys.size(), prony->num_internal() + body_.term->num_internal());
  ASSERT_EQ(keys_of_whole.size(), of_whole->num_internal() + whole.term->num_internal());
  std::map<EntryKey, std::size_t> place;
  for (std::size_t i = 0; i < keys_of_whole.size(); ++i) place[keys_of_whole[i]] = i;
  ASSERT_EQ(place.size(), keys_of_whole.size());
  const ConstArrayView here(body_.z.get()), there(whole.z.get());
  for (std::size_t i = prony->num_internal(); i < keys.size(); ++i) {
    ASSERT_TRUE(place.contains(keys[i]));
    ASSERT_GE(place[keys[i]], of_whole->num_internal());
    const double expected = there.span()[place[keys[i]] - of_whole->num_internal()];
    EXPECT_NEAR(here.span()[i - prony->num_internal()], expected, 1e-12 * expected);
  }
}

}  // namespace
}  // namespace pliant::test_mullins
