/// A kind of elastic law in the registry: the functions made from its type, next to the row for users.
#pragma once

#include "material/energy_change.hpp"
#include "material/law_field.hpp"

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace pliant {

template <class L>
inline constexpr bool has_volumetric_form = requires(const L& law) {
  law.volumetric;
};

template <ElasticLaw L>
constexpr LawTraits traits_of() {
  return {L::is_barrier, L::constant_tangent, L::num_directions, L::energy_degree, has_volumetric_form<L>};
}

/// The laws at a body's packs of points, as make_law_field promises them.
using LawOfLane = std::function<ElasticLawSpec(std::size_t n, int lane)>;

struct LawKind {
  LawTraits traits;
  std::optional<Lame> (*at_rest)(const ElasticLawSpec& law);
  std::unique_ptr<LawField> (*field)(std::size_t num_packs, const LawOfLane& at);
  /// P(H) and Hooke's constants at rest with their derivatives by the parameters (material/parameter_slope.hpp);
  /// nullptr for laws that are not isotropic.
  Tensor3<Dual<double>> (*dual_stress)(const LawData<Dual<double>>& data, const Tensor3<double>& H) = nullptr;
  LameOf<Dual<double>> (*dual_at_rest)(const LawData<Dual<double>>& data) = nullptr;
};

template <ElasticLaw L>
class LawFieldOf final : public LawField {
 public:
  explicit LawFieldOf(std::vector<L> laws) : laws_(std::move(laws)), stride_(laws_.size() == 1 ? 0 : 1) {}

  LawTraits traits() const override { return traits_of<L>(); }
  Pack psi(std::size_t n, const Tensor3<Pack>& H) const override { return law(n).psi(H); }
  Pack psi_change(std::size_t n, const Tensor3<Pack>& H, const Tensor3<Pack>& dH) const override {
    return energy_change(law(n), H, dH);
  }
  Tensor3<Pack> P(std::size_t n, const Tensor3<Pack>& H) const override { return law(n).P(H); }
  void tangent(std::size_t n, const Tensor3<Pack>& H, Tangent<Pack>& A) const override {
    A = law(n).linearize(H).tangent();
  }

 private:
  const L& law(std::size_t n) const { return laws_[n * stride_]; }

  std::vector<L> laws_;  // one, or one per pack of points
  std::size_t stride_;
};

/// Joins the laws of a pack's lanes to one law on packs.
template <class L>
L packed(const std::array<ElasticLawSpec, pack_size>& lanes) {
  const ElasticLawSpec& first = lanes.front();
  const auto pack = [&](auto&& value) { return Pack([&](auto lane) { return value(lanes[lane]); }); };
  std::vector<Pack> parameters;
  for (std::size_t p = 0; p < first.parameters.size(); ++p) {
    parameters.push_back(pack([p](const ElasticLawSpec& spec) { return spec.parameters[p]; }));
  }
  LawData<Pack> data{parameters, first.volumetric};
  for (std::size_t d = 0; d < 2; ++d) {
    for (std::size_t i = 0; i < 3; ++i) {
      data.directions[d][i] = pack([d, i](const ElasticLawSpec& spec) { return spec.directions[d][i]; });
    }
  }
  return L::of(data);
}

template <template <class> class L>
requires ElasticLawTemplate<L>
constexpr LawKind law_kind() {
  LawKind kind{traits_of<L<double>>(),
               [](const ElasticLawSpec& law) -> std::optional<Lame> {
                 if constexpr (IsotropicLaw<L<double>>) {
                   return L<double>::of({law.parameters, law.volumetric, law.directions}).at_rest();
                 } else {
                   return std::nullopt;
                 }
               },
               [](std::size_t num_packs, const LawOfLane& at) -> std::unique_ptr<LawField> {
                 std::vector<L<Pack>> laws;
                 for (std::size_t n = 0; n < num_packs; ++n) {
                   std::array<ElasticLawSpec, pack_size> lanes;
                   for (int lane = 0; lane < pack_size; ++lane) lanes[lane] = at(n, lane);
                   laws.push_back(packed<L<Pack>>(lanes));
                 }
                 return std::make_unique<LawFieldOf<L<Pack>>>(std::move(laws));
               }};
  if constexpr (IsotropicLaw<L<double>>) {
    kind.dual_stress = [](const LawData<Dual<double>>& data, const Tensor3<double>& H) {
      return L<Dual<double>>::of(data).P(make_tensor([&](int i, int j) -> Dual<double> { return H(i, j); }));
    };
    kind.dual_at_rest = [](const LawData<Dual<double>>& data) { return L<Dual<double>>::of(data).at_rest(); };
  }
  return kind;
}

/// The kind of the law in that row.
const LawKind& kind_of(std::size_t row);

/// Adds a law that inputs can name; all commands then know its name and keys as those of the other laws. The data that
/// `info` refers to must exist until the program ends. To be called by one thread, before the first input is read.
/// Throws std::invalid_argument if there already is a law of this name.
void add_elastic_law(const LawInfo& info, const LawKind& kind);

}  // namespace pliant
