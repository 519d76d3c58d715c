#include "run/energy_watch.hpp"

#include <gtest/gtest.h>

namespace pliant {
namespace {

Energies at(double kinetic, double elastic, double potential, double work) {
  Energies e;
  e.kinetic = kinetic;
  e.elastic = elastic;
  e.load_potential = potential;
  e.load_work = work;
  return e;
}

// A fall: the potential turns into motion; later a load pushes. Nothing is made.
TEST(EnergyWatch, MotionThatLoadsDriveIsSound) {
  EnergyWatch watch(at(0, 0, 0, 0));
  for (int k = 1; k <= 10; ++k) watch.look(at(0.9 * k, 0.1 * k, -k, 0), 0.1 * k);
  watch.look(at(0, 60, -10, 50), 2.0);
  EXPECT_FALSE(watch.growth());
}

// While a load grows from zero, an error of truncation is as large as what came in; later it is small.
TEST(EnergyWatch, ErrorsAtTheStartDoNotCount) {
  EnergyWatch watch(at(0, 0, 0, 0));
  watch.look(at(0.002, 0, 0, 0.001), 0.1);
  watch.look(at(1.002, 0, 0, 1.0), 0.2);
  EXPECT_FALSE(watch.growth());
}

TEST(EnergyWatch, TellsHowMuchThereIsOfWhatCameIn) {
  EnergyWatch watch(at(3, 1, 7, 0));
  watch.look(at(5, 1, 6, 1), 0.1);  // 4 at the start, 1 of potential, 1 of work
  watch.look(at(9, 9, 6, 1), 0.2);
  watch.look(at(6, 6, 6, 1), 0.3);
  ASSERT_TRUE(watch.growth());
  EXPECT_DOUBLE_EQ(watch.growth()->factor, 3.0);
  EXPECT_DOUBLE_EQ(watch.growth()->time, 0.2);
}

// A body at rest without loads has rounding errors alone, which may grow and vanish.
TEST(EnergyWatch, RoundingErrorsAreNoEnergy) {
  for (const double rounding : {0.0, 1e-26}) {
    EnergyWatch watch(at(1e-26, 0, 0, 0));
    watch.look(at(8e-26, 1e-26, 0, 0), 0.1, rounding);
    Energies end = at(0, 0, 0, 0);
    end.numerical_dissipation = 4e-26;
    EXPECT_EQ(watch.sees_only_rounding(), rounding > 0.0);
    EXPECT_EQ(watch.growth().has_value(), rounding == 0.0);
    EXPECT_EQ(watch.loss(end).has_value(), rounding == 0.0);
    watch.look(at(1, 0, 0, 0), 0.2, rounding);
    EXPECT_FALSE(watch.sees_only_rounding());
    EXPECT_TRUE(watch.growth());
  }
}

// A body that rests has no energy to compare with.
TEST(EnergyWatch, TellsOfMoreDissipatedThanThereWas) {
  EnergyWatch watch(at(4, 0, 0, 0));
  Energies lost = at(1, 0, 0, 0);
  lost.dissipated = 4.5;
  watch.look(lost, 0.1);
  EXPECT_FALSE(watch.growth());
  lost.dissipated = 7;
  watch.look(lost, 0.2);
  ASSERT_TRUE(watch.growth());
  EXPECT_TRUE(watch.growth()->includes_dissipation);
  EXPECT_DOUBLE_EQ(watch.growth()->factor, 2.0);
  EXPECT_DOUBLE_EQ(watch.growth()->time, 0.2);
}

TEST(EnergyWatch, TellsWhatAMethodTakesOut) {
  EnergyWatch watch(at(3, 1, 7, 0));
  Energies end = at(2, 1, 6, 1);  // of 6 J: 4 at the start, 1 of potential, 1 of work
  watch.look(end, 0.1);
  end.numerical_dissipation = 1.5;
  EXPECT_FALSE(watch.loss(end));
  end.numerical_dissipation = 2.0;
  ASSERT_TRUE(watch.loss(end));
  EXPECT_DOUBLE_EQ(watch.loss(end)->supplied, 6.0);
  EXPECT_DOUBLE_EQ(watch.loss(end)->share(), 1.0 / 3.0);
}

TEST(EnergyWatch, RoundingOfNothingIsNothing) {
  EnergyWatch watch(at(0, 0, 0, 0));
  watch.look(at(1e-40, 0, 0, 0), 0.1);
  EXPECT_FALSE(watch.growth());
}

}  // namespace
}  // namespace pliant
