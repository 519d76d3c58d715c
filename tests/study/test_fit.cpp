// What a material shows in each kind of test has the derivatives that differences show, and a fit finds known
// constants.
#include "places.hpp"
#include "study/fit.hpp"
#include "study/fit_data.hpp"
#include "study/fit_input.hpp"
#include "study/relaxation.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>
#include <vector>

#include <gtest/gtest.h>

namespace pliant::test_fit {
namespace {

/// A material and tests of it, by the text of a fit file.
struct Case {
  const char* name;
  std::string material;
  std::string test;
  std::vector<double> x;       ///< where it is tested
  std::vector<double> values;  ///< of the free parameters
};

void PrintTo(const Case& one, std::ostream* out) {
  *out << one.name;
}

const std::string elastic = "material: {model: ogden, terms: 2, incompressible: true}\n";
const std::string prony = "viscosity: {model: prony, terms: 2}\n";
const std::vector<double> two_terms{3e5, 1.7, 2e4, 4.2};
const std::vector<double> with_branches{2e5, 0.5, 0.2, 0.8, 7.0};

std::vector<Case> every_case() {
  const std::vector<double> stretches{0.6, 0.9, 1.0, 1.5, 3.0};
  const std::string yeoh = "material: {model: yeoh, poissons_ratio: 0.45}\n";
  const std::string two = "material: {model: neo-hookean}\n";
  const std::string bar = "material: {model: neo-hookean, incompressible: true}\n" + prony;
  const std::string soft = "material: {model: neo-hookean, poissons_ratio: 0.3}\n" + prony;
  return {{"uniaxial", elastic, "kind: uniaxial", stretches, two_terms},
          {"equibiaxial", elastic, "kind: equibiaxial", stretches, two_terms},
          {"pure_shear", elastic, "kind: pure-shear", stretches, two_terms},
          {"simple_shear", elastic, "kind: simple-shear", {1.3, 2.0}, two_terms},
          {"compressible_uniaxial", yeoh, "kind: uniaxial", stretches, {2e5, -2e3, 50.0}},
          {"compressible_equibiaxial", yeoh, "kind: equibiaxial", {0.8, 1.2, 1.8}, {2e5, -2e3, 50.0}},
          {"compressible_pure_shear", two, "kind: pure-shear", stretches, {4e5, 2e6}},
          {"compressible_simple_shear", two, "kind: simple-shear", {1.5}, {4e5, 2e6}},
          {"volumetric", two, "kind: volumetric", {0.8, 0.95, 1.1}, {4e5, 2e6}},
          {"sudden", bar, "kind: relaxation, stretch: 1.5", {0.0, 0.1, 1.0, 20.0}, with_branches},
          {"sudden_shear", bar, "kind: relaxation, loading: simple-shear, shear: 0.4", {0.1, 9.0}, with_branches},
          {"ramp", bar, "kind: relaxation, stretch: 2, rate: 0.5 Hz", {0.3, 1.9, 2.0, 2.1, 30.0}, with_branches},
          {"compressible_ramp", soft, "kind: relaxation, stretch: 0.7, rate: 0.1 Hz", {1.0, 3.0, 9.0}, with_branches},
          {"dma", soft, "kind: dma", {0.01, 0.3, 8.0}, with_branches},
          {"dma_in_shear", bar, "kind: dma, loading: simple-shear", {0.01, 0.3, 8.0}, with_branches}};
}

class EveryTest : public testing::TestWithParam<Case> {};

TEST_P(EveryTest, HasTheDerivativesThatDifferencesShow) {
  const Case& one = GetParam();
  const FitConfig config = read_fit(one.material + "tests: [{data: none.csv, " + one.test + "}]\n", "fit.yaml");
  const FitMaterial material(config.material, config.viscosity);
  MaterialTest test{config.tests.front(), "", one.x, {}, ""};
  const Loading loading_of_kind = test_kinds()[static_cast<std::size_t>(test.config.kind)].loading;
  test.config.loading = test.is_elastic() ? loading_of_kind : test.config.loading.value_or(Loading::uniaxial);
  ASSERT_EQ(material.num_free(), one.values.size());
  const auto at = [&](std::size_t j, double change) {
    auto values = one.values;
    values[j] += change;
    return test.predicted(material, material.all_values(values), one.x);
  };
  const auto exact = test.predicted(material, material.all_values(one.values), one.x);
  double seen = 0.0;
  for (std::size_t j = 0; j < one.values.size(); ++j) {
    const double h = 1e-4 * std::abs(one.values[j]);
    const auto right = at(j, h), left = at(j, -h), near_right = at(j, 0.5 * h), near_left = at(j, -0.5 * h);
    for (std::size_t i = 0; i < exact.size(); ++i) {
      // Extrapolated once: the error is h^4 and 1e-16/h of the value.
      const double wide = (right[i].value - left[i].value) / (2.0 * h);
      const double narrow = (near_right[i].value - near_left[i].value) / h;
      const double size = 1e-8 * (1.0 + std::abs(exact[i].value));
      EXPECT_NEAR(exact[i].slopes[j] * one.values[j], (4.0 * narrow - wide) / 3.0 * one.values[j], size)
          << "parameter " << j << ", place " << i;
      seen += std::abs(exact[i].slopes[j] * one.values[j]);
    }
  }
  EXPECT_GT(seen, 1e4);
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryTest, testing::ValuesIn(every_case()),
                         [](const auto& one) { return one.param.name; });

TEST(Relaxation, AFastRampIsASuddenStretchAndASlowOneIsElastic) {
  const std::vector<PronyBranch> series{{0.5, 0.2}, {0.8, 7.0}};
  // S_e linear in the stretch: the nominal stress of the elastic law is l (l - 1).
  const auto stress = [&](double rate, double t) {
    const RelaxationHistory history(1.5, rate);
    const auto weights = history.weights(t, series);
    double sum = 0.0;
    for (std::size_t j = 0; j < weights.total.size(); ++j) {
      const double l = history.amounts()[j];
      sum += weights.total[j] * l * (l - 1.0);
    }
    return sum;
  };
  const auto in_closed_form = [&](double rate, double t) {
    const double duration = 0.5 / rate, until = std::min(t, duration), held = 1.0 + rate * until;
    double sum = held - 1.0;
    for (const auto& [g, tau] : series) {
      sum += g * rate * tau * (std::exp(-(t - until) / tau) - std::exp(-t / tau));
    }
    return held * sum;
  };
  for (const double rate : {1e4, 1.0, 0.3, 1e-3}) {
    for (const double t : {0.01, 0.4, 1.0, 5.0, 400.0, 600.0}) {
      EXPECT_NEAR(stress(rate, t), in_closed_form(rate, t), 1e-11) << rate << ", " << t;
    }
  }
}

/// A directory that goes when the test ends.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("pliant_fit_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name) << text;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

TEST(Measurements, HaveUnitsInTheirHeader) {
  const Folder folder;
  const std::vector<std::vector<ColumnForm>> wanted{{{"stretch", "1"}, {"strain", "1", 1.0, 1.0}}, {{"stress", "Pa"}}};
  const auto file = folder.write(
      "table.csv",
      "\xEF\xBB\xBF# by hand\r\nsample, Strain [%] ,\"Stress (MPa)\"\r\na, 50,0.25\r\n\r\nb,-20,-1e-1\r\n");
  const auto [columns, note] = read_measurements(file, {}, wanted);
  EXPECT_EQ(columns[0], (std::vector<double>{1.5, 0.8}));
  EXPECT_EQ(columns[1], (std::vector<double>{0.25e6, -0.1e6}));
  EXPECT_EQ(note, "");
}

TEST(Measurements, AreInSIWithoutAUnitAndSayThat) {
  const Folder folder;
  const std::vector<std::vector<ColumnForm>> wanted{{{"stretch", "1"}}, {{"stress", "Pa"}}};
  const auto file = folder.write("table.csv", "stretch,stress\n1.1,55\n");
  const auto [columns, note] = read_measurements(file, {}, wanted);
  EXPECT_EQ(columns[1], (std::vector<double>{55.0}));
  EXPECT_NE(note.find("read in SI units: stress in Pa; state another as in 'stress [MPa]'"), std::string::npos) << note;
}

TEST(Measurements, AskAboutPerCentWhereStrainsAreBeyondRubber) {
  const Folder folder;
  const std::vector<std::vector<ColumnForm>> wanted{{{"stretch", "1"}, {"strain", "1", 1.0, 1.0}}};
  for (const auto& [text, asks] : {std::pair{"strain\n0.5\n12\n", false},
                                   {"strain\n50\n100\n", true},
                                   {"strain [%]\n50\n100\n", false},
                                   {"stretch\n50\n", false}}) {
    const auto [columns, note] = read_measurements(folder.write("table.csv", text), {}, wanted);
    EXPECT_EQ(note.find("strains of 100 are 10000 %; if they are in per cent") != std::string::npos, asks) << note;
  }
}

TEST(FitFile, ShippedFitsAreGood) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(source_root() / "input/fit")) {
    std::ifstream stream(entry.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const FitConfig config = read_fit(text, entry.path().string());
    for (const FitTestConfig& test : config.tests) {
      EXPECT_FALSE(read_test(test, entry.path().parent_path().string()).x.empty()) << entry.path();
    }
    ++count;
  }
  EXPECT_GT(count, 0);
}

TEST(FitOfAMaterial, FindsTheModulusAndItsError) {
  const Folder folder;
  // Residuals of 1 and -1 kPa at the same stretch: the mean counts, and its error is known.
  folder.write("table.csv", "stretch,stress [kPa]\n2,176\n2,174\n");
  const auto file = folder.write("fit.yaml",
                                 "material: {model: neo-hookean, incompressible: true}\n"
                                 "tests: [{kind: uniaxial, data: table.csv}]\n");
  std::ifstream stream(file);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const FittedMaterial fit = fit_material(text, file);
  EXPECT_TRUE(fit.outcome.minimum.is_converged);
  EXPECT_NEAR(fit.outcome.values[0], 1e5, 1e-6);  // 175 kPa = mu (2 - 1/4)
  EXPECT_NEAR(fit.outcome.sums[0], 2e6, 1e-3);
  EXPECT_NEAR(fit.outcome.standard_errors[0], std::sqrt(2e6 / 2.0) / 1.75, 1e-3);
}

}  // namespace
}  // namespace pliant::test_fit
