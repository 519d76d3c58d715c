#include "material/law_field.hpp"

#include "material/energy_change.hpp"
#include "material/registry.hpp"

#include <utility>

namespace pliant {
namespace {

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

/// The laws of the lanes of a pack as one law of packs.
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

template <std::size_t... row>
std::unique_ptr<LawField> make(const ElasticLawSpec& common, std::size_t num_packs,
                               const std::function<ElasticLawSpec(std::size_t, int)>& at, std::index_sequence<row...>) {
  std::unique_ptr<LawField> field;
  const auto consider = [&]<class L>(std::type_identity<L>) {
    std::vector<L> laws;
    for (std::size_t n = 0; n < num_packs; ++n) {
      std::array<ElasticLawSpec, pack_size> lanes;
      for (int lane = 0; lane < pack_size; ++lane) lanes[lane] = at(n, lane);
      laws.push_back(packed<L>(lanes));
    }
    field = std::make_unique<LawFieldOf<L>>(std::move(laws));
  };
  ((row == common.row ? consider(std::type_identity<std::variant_alternative_t<row, ElasticLaws::Variant<Pack>>>{})
                      : void()),
   ...);
  return field;
}

}  // namespace

std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& uniform) {
  return make_law_field(uniform, 1, [&](std::size_t, int) { return uniform; });
}

std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& common, std::size_t num_packs,
                                         const std::function<ElasticLawSpec(std::size_t, int)>& at) {
  return make(common, num_packs, at, std::make_index_sequence<ElasticLaws::size>{});
}

}  // namespace pliant
