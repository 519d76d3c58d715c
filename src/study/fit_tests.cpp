#include "study/fit_tests.hpp"

#include "base/limits.hpp"
#include "study/fit_data.hpp"
#include "study/relaxation.hpp"

#include <array>
#include <cmath>
#include <filesystem>
#include <numbers>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::array<TestKindInfo, 7> kinds{
    {{"uniaxial", Loading::uniaxial, "stretch", "nominal stress [Pa]"},
     {"equibiaxial", Loading::equibiaxial, "stretch", "nominal stress [Pa]"},
     {"pure-shear", Loading::pure_shear, "stretch", "nominal stress [Pa]"},
     {"simple-shear", Loading::simple_shear, "1 + amount of shear", "shear stress [Pa]"},
     {"volumetric", Loading::volumetric, "volume ratio", "pressure [Pa]"},
     {"relaxation", Loading::uniaxial, "time [s]", "nominal stress [Pa]"},
     {"dma", Loading::uniaxial, "angular frequency [1/s]", "modulus [Pa]"}}};

using Columns = std::vector<std::vector<ColumnForm>>;

Columns columns_of(TestKind kind) {
  const std::vector<ColumnForm> stress{{"stress", "Pa"}};
  switch (kind) {
    case TestKind::simple_shear:
      return {{{"shear", "1", 1.0, 1.0}, {"shear_strain", "1", 1.0, 1.0}}, {{"stress", "Pa"}, {"shear_stress", "Pa"}}};
    case TestKind::volumetric:
      return {{{"volume_ratio", "1"}}, {{"pressure", "Pa"}}};
    case TestKind::relaxation:
      return {{{"time", "s"}}, stress};
    case TestKind::dma:
      return {{{"frequency", "Hz", 2.0 * std::numbers::pi}, {"angular_frequency", "1/s"}},
              {{"storage_modulus", "Pa"}},
              {{"loss_modulus", "Pa"}}};
    default:
      return {{{"stretch", "1"}, {"strain", "1", 1.0, 1.0}}, stress};
  }
}

/// Rows that no test can have measured.
void check_rows(const MaterialTest& test, const std::string& file) {
  const bool needs_positive = test.config.kind != TestKind::relaxation;
  for (const double x : test.x) {
    if (needs_positive ? x > 0.0 : x >= 0.0) continue;
    throw InputError({file, 0, 0}, fmt::format("the first column has the value {:g}; {}", x,
                                               needs_positive ? "it must be above 0 (a 'strain' above -1)"
                                                              : "times count from 0, when the stretch begins"));
  }
}

/// The branches of the material with their derivatives: place among the free parameters, or none.
struct Branch {
  double ratio, time;
  std::optional<std::size_t> ratio_place, time_place;
};

std::vector<Branch> branches_of(const FitMaterial& material, std::span<const double> all) {
  std::vector<Branch> branches;
  for (std::size_t n = 0; n < material.num_branches(); ++n) {
    const std::size_t ratio = material.ratio_index(n);
    branches.push_back({material.ratio(all, n), material.relaxation_time(all, n), material.free_place(ratio),
                        material.free_place(ratio + 1)});
  }
  return branches;
}

void add(std::vector<double>& slopes, const std::optional<std::size_t>& place, double slope) {
  if (place) slopes[*place] += slope;
}

/// E' = E (1 + sum g w^2/(1 + w^2)), E'' = E sum g w/(1 + w^2), w = omega tau: the moduli of Prony's branches at small
/// strain, E at rest. Source: Ferry, Viscoelastic Properties of Polymers (3rd ed. 1980), chapter 3.
std::vector<Sensitive> dynamic_moduli(const FitMaterial& material, std::span<const double> all, Loading loading,
                                      std::span<const double> frequencies) {
  const Sensitive rest = material.modulus(all, loading);
  const auto branches = branches_of(material, all);
  std::vector<Sensitive> result;
  for (const double omega : frequencies) {
    double storage = 1.0, loss = 0.0;
    std::vector<double> of_storage(material.num_free(), 0.0), of_loss = of_storage;
    for (const Branch& b : branches) {
      const double w = omega * b.time, d = 1.0 + w * w;
      storage += b.ratio * w * w / d;
      loss += b.ratio * w / d;
      add(of_storage, b.ratio_place, w * w / d);
      add(of_loss, b.ratio_place, w / d);
      add(of_storage, b.time_place, b.ratio * 2.0 * w * omega / (d * d));
      add(of_loss, b.time_place, b.ratio * omega * (1.0 - w * w) / (d * d));
    }
    for (const auto& [part, of_part] : {std::pair(storage, &of_storage), std::pair(loss, &of_loss)}) {
      Sensitive modulus{rest.value * part, rest.slopes};
      for (std::size_t k = 0; k < modulus.slopes.size(); ++k) {
        modulus.slopes[k] = rest.slopes[k] * part + rest.value * (*of_part)[k];
      }
      result.push_back(std::move(modulus));
    }
  }
  return result;
}

/// x - factor y.
Sensitive difference(const Sensitive& x, double factor, const Sensitive& y) {
  Sensitive result = x;
  result.value -= factor * y.value;
  for (std::size_t k = 0; k < result.slopes.size(); ++k) result.slopes[k] -= factor * y.slopes[k];
  return result;
}

/// The elastic stresses on the way of which study/relaxation.hpp has the weights, as the time needs them.
class ElasticStresses {
 public:
  ElasticStresses(const FitMaterial& material, std::span<const double> all, Loading loading,
                  const RelaxationHistory& history)
      : loading_(loading), history_(history) {
    if (material.is_incompressible() && history.amounts().size() > 1) {
      of_law_ = material.stresses_of_law(all, loading, history.amounts());
    } else {
      at_rest_ = material.stress(all, loading, history.amounts());
    }
  }

  std::vector<Sensitive> at(double t) const {
    if (of_law_.empty()) return at_rest_;
    const Tensor3<double> H = incompressible_state(loading_, history_.amount_at(t));
    const int across = free_entries(loading_).front();
    const double ratio = (1.0 + H(across, across)) / (1.0 + H(0, 0));
    std::vector<Sensitive> result;
    for (const auto& [along, aside] : of_law_) result.push_back(difference(along, ratio * ratio, aside));
    return result;
  }

 private:
  Loading loading_;
  const RelaxationHistory& history_;
  std::vector<Sensitive> at_rest_;
  std::vector<std::array<Sensitive, 2>> of_law_;
};

/// The nominal stress of a specimen that is stretched and held: weights of study/relaxation.hpp times the elastic
/// stresses on the way, and their derivatives.
std::vector<Sensitive> relaxing_stress(const FitMaterial& material, std::span<const double> all,
                                       const MaterialTest& test, std::span<const double> times) {
  const auto branches = branches_of(material, all);
  std::vector<PronyBranch> series;
  for (const Branch& b : branches) series.push_back({b.ratio, b.time});
  const RelaxationHistory history(test.held_amount(), test.config.rate);
  const ElasticStresses stresses(material, all, *test.config.loading, history);
  std::vector<Sensitive> result;
  for (const double t : times) {
    const auto elastic = stresses.at(t);
    const RelaxationWeights weights = history.weights(t, series);
    Sensitive stress{0.0, std::vector<double>(material.num_free(), 0.0)};
    for (std::size_t j = 0; j < elastic.size(); ++j) {
      stress.value += weights.total[j] * elastic[j].value;
      for (std::size_t k = 0; k < stress.slopes.size(); ++k)
        stress.slopes[k] += weights.total[j] * elastic[j].slopes[k];
      for (std::size_t n = 0; n < branches.size(); ++n) {
        add(stress.slopes, branches[n].ratio_place, weights.by_ratio[n][j] * elastic[j].value);
        add(stress.slopes, branches[n].time_place, weights.by_time[n][j] * elastic[j].value);
      }
    }
    result.push_back(std::move(stress));
  }
  return result;
}

}  // namespace

std::span<const TestKindInfo> test_kinds() {
  return kinds;
}

double MaterialTest::held_amount() const {
  return config.shear ? 1.0 + *config.shear : config.stretch.value_or(1.0);
}

std::vector<Sensitive> MaterialTest::predicted(const FitMaterial& material, std::span<const double> all,
                                               std::span<const double> at) const {
  if (config.kind == TestKind::dma) return dynamic_moduli(material, all, *config.loading, at);
  if (config.kind == TestKind::relaxation) return relaxing_stress(material, all, *this, at);
  return material.stress(all, *config.loading, at);
}

MaterialTest read_test(const FitTestConfig& config, const std::string& directory) {
  namespace fs = std::filesystem;
  const std::string file = (fs::path(directory) / config.data.value).string();
  MaterialTest test{config, "", {}, {}, ""};
  const TestKindInfo& info = kinds[static_cast<std::size_t>(config.kind)];
  test.config.loading = test.is_elastic() ? info.loading : config.loading.value_or(Loading::uniaxial);
  test.name = fmt::format("{} {}", info.name, fs::path(config.data.value).filename().string());
  auto [columns, note] = read_measurements(file, config.data.where, columns_of(config.kind));
  test.note = std::move(note);
  if (config.kind == TestKind::dma && !config.loading) {
    test.note += fmt::format(
        "{}its moduli count as Young's, E' and E'' of `loading: uniaxial`; for shear moduli G' and G'' write `loading: "
        "simple-shear`",
        test.note.empty() ? file + ": " : "; ");
  }
  test.x = std::move(columns[0]);
  for (std::size_t n = 0; n < test.x.size(); ++n) {
    for (std::size_t k = 1; k < columns.size(); ++k) test.y.push_back(columns[k][n]);
  }
  check_rows(test, file);
  return test;
}

}  // namespace pliant
