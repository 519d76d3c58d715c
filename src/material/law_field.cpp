#include "material/law_field.hpp"

#include "material/registry.hpp"

#include <algorithm>
#include <stdexcept>

namespace pliant {
namespace {

template <template <class> class... L>
std::vector<LawKind> kinds_of(LawList<L...>) {
  return {law_kind<L>()...};
}

/// In the order of elastic_laws().
std::vector<LawKind>& kinds() {
  static std::vector<LawKind> all = kinds_of(ElasticLaws{});
  return all;
}

}  // namespace

const LawKind& kind_of(std::size_t row) {
  return kinds().at(row);
}

void add_elastic_law(const LawInfo& info, const LawKind& kind) {
  if (std::ranges::find(elastic_laws(), info.name, &LawInfo::name) != elastic_laws().end()) {
    throw std::invalid_argument("there already is a law '" + std::string(info.name) + "'");
  }
  kinds().push_back(kind);
  add_row(info);
}

std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& uniform) {
  return make_law_field(uniform, 1, [&](std::size_t, int) { return uniform; });
}

std::unique_ptr<LawField> make_law_field(const ElasticLawSpec& common, std::size_t num_packs,
                                         const std::function<ElasticLawSpec(std::size_t, int)>& at) {
  // What a field says of a body without points here is never used, but it is asked.
  if (num_packs == 0) return make_law_field(typical_law(common.row));
  return kind_of(common.row).field(num_packs, at);
}

}  // namespace pliant
