// Internal variables are found again under their keys on any number of ranks.
#include "energy/volume/internal_keys.hpp"
#include "energy/volume/viscous_body.hpp"

#include <map>

namespace pliant::test_internal_keys {
namespace {

using test::at_time;
using test::BodySpec;
using test::Scratch;
using test::Shape;
using test::Solid;
using test::TestStage;

const MPI_Comm comm = MPI_COMM_WORLD;

/// A body with a Prony series of two branches and a Maxwell branch, after a stage.
struct RelaxingBody {
  RelaxingBody(MPI_Comm on, const std::string& file, int order)
      : solid(on, file, order, 2 * (order - 1)),
        prony(solid.prony({{0.3, 0.1}, {0.5, 0.02}}, "neo-hookean")),
        maxwell(solid.viscous(Maxwell{300.0, 500.0, 0.1})),
        potential(solid.layout(), solid.pattern(), {prony.get(), maxwell.get()}, solid.nothing_prescribed()),
        z(potential.make_internal()) {
    TestStage stage(solid, 0.7, test::viscous_dt, at_time(-0.1));
    const Handle<Vec> rest = potential.make_internal(), q = solid.vector(at_time(0.0));
    stage.point.z0 = rest.get();
    potential.internal_variables().end_stage(stage.point, q.get(), z.get());
    keys = internal_keys(solid.layout(), potential.terms());
  }
  std::vector<double> values() const {
    const ConstArrayView view(z.get());
    return {view.span().begin(), view.span().end()};
  }

  Solid solid;
  std::unique_ptr<EnergyTerm> prony, maxwell;
  IncrementalPotential potential;
  Handle<Vec> z;
  std::vector<EntryKey> keys;
};

class InternalKeys : public ::testing::TestWithParam<BodySpec> {
 protected:
  Scratch scratch_{comm};
  std::string file_ = scratch_.file("body.msh", [](const std::string& f) { write_body(f, GetParam()); });
};

TEST_P(InternalKeys, NameTheSameTensorsOnAnyNumberOfRanks) {
  const RelaxingBody spread(comm, file_, GetParam().order), whole(MPI_COMM_SELF, file_, GetParam().order);
  const auto all = whole.values(), here = spread.values();
  ASSERT_EQ(6 * whole.keys.size(), all.size());
  ASSERT_EQ(6 * spread.keys.size(), here.size());
  std::map<EntryKey, std::size_t> place;
  double largest = 0.0;
  for (std::size_t i = 0; i < whole.keys.size(); ++i) place[whole.keys[i]] = 6 * i;
  for (const double value : all) largest = std::max(largest, std::abs(value));
  ASSERT_EQ(place.size(), whole.keys.size());
  ASSERT_GT(largest, 0.0);
  for (std::size_t i = 0; i < spread.keys.size(); ++i) {
    ASSERT_TRUE(place.contains(spread.keys[i]));
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(here[6 * i + k], all[place[spread.keys[i]] + k], 1e-13 * largest);
    }
  }
}

TEST_P(InternalKeys, BringThemToTheirRowsAndBackGhostsIncluded) {
  const RelaxingBody body(comm, file_, GetParam().order);
  const GlobalOrder order(comm, body.keys);
  const auto values = body.values();
  const auto back = order.entries(order.rows(values, 6), 6);
  ASSERT_EQ(back.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(back[i], values[i]);  // a ghost's numbers are its owner's
}

INSTANTIATE_TEST_SUITE_P(Bodies, InternalKeys,
                         ::testing::Values(BodySpec{1, Shape::jittered, 2}, BodySpec{2, Shape::jittered, 2},
                                           BodySpec{2, Shape::curved, 2}),
                         [](const auto& of) { return test::name_of(of.param); });

}  // namespace
}  // namespace pliant::test_internal_keys
