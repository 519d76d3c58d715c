/// The pairs of a coupling within another distance than its own.
#pragma once

#include "energy/coupling.hpp"

#include <memory>

namespace pliant {

/// The pairs of a term within another distance than its reach.
class ObservedPairs final : public PairCoupling {
 public:
  ObservedPairs(const PairCoupling& coupling, double reach) : coupling_(coupling), reach_(reach) {}
  const Patches& patches() const override { return coupling_.patches(); }
  double reach() const override { return reach_; }
  double slack() const override { return coupling_.slack(); }
  bool may_couple(int tag, int other) const override { return coupling_.may_couple(tag, other); }
  std::shared_ptr<const PairFeatures> features_of(const NearPatches& near) const override {
    return coupling_.features_of(near);
  }
  bool couples(std::int64_t key, std::int64_t other) const override { return coupling_.couples(key, other); }

 private:
  const PairCoupling& coupling_;
  double reach_;
};

}  // namespace pliant
