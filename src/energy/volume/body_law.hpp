/// The elastic law of a body whose shape free of stress may change with time: its fibres shorten, and it expands.
#pragma once

#include "energy/volume/active_strain.hpp"
#include "energy/volume/body_cells.hpp"
#include "energy/volume/expansion.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace pliant {

/// Values at points of cells, replaced by their means over the cells where these are first asked for: at the index of
/// a cell's first point.
template <int Order>
PerPoint<Pack> means_over_cells(const BodyCells<Order>& cells, PerPoint<Pack> values) {
  if (values.values.size() <= 1) return values;
  cells.for_each_batch([&](const CellBatch<Order>& batch) {
    Pack integral = 0.0, volume = 0.0;
    for (int k = 0; k < batch.group.rule.size(); ++k) {
      const CellPoint<Order> point{batch, k};
      integral += point.weight() * values[point.index()];
      volume += point.weight();
    }
    Pack& first = values.values[CellPoint<Order>{batch, 0}.index()];
    first = select(volume > 0.0, integral / select(volume > 0.0, volume, Pack(1.0)), first);
  });
  return values;
}

class BodyLaw {
 public:
  explicit BodyLaw(std::shared_ptr<const LawField> law, FreeShape shape = {})
      : law_(std::move(law)), shape_(std::move(shape)) {}

  LawTraits traits() const { return law_->traits(); }
  bool depends_on_time() const { return shape_.shortening != nullptr || shape_.expansion != nullptr; }

  /// The law at an instant. It must not outlive the object.
  class Now {
   public:
    explicit Now(const LawField& law) : law_(&law) {}
    const LawField* operator->() const { return law_; }
    const LawField& operator*() const { return *law_; }

    template <class Law, class... Args>
    void wrap(Args&&... args) {
      own_.push_back(std::make_unique<Law>(*law_, std::forward<Args>(args)...));
      law_ = own_.back().get();
    }

   private:
    std::vector<std::unique_ptr<const LawField>> own_;
    const LawField* law_;
  };
  Now at(const Instant& instant) const {
    Now law = shortened(instant);
    if (shape_.expansion) law.wrap<ExpandedLaw>(expanded(instant));
    return law;
  }

  /// Likewise at the centroids of the cells, at the index of their first points.
  template <int Order>
  Now at_centroids(const Instant& instant, const BodyCells<Order>& cells) const {
    Now law = shortened(instant);
    if (shape_.expansion) law.wrap<ExpandedLaw>(expanded_at_centroids(instant, cells));
    return law;
  }

  /// How the expansion is split off.
  PerPoint<ExpandedPoint> expanded(const Instant& instant) const {
    return expanded_points(shape_.expansion.get(), instant, split_of(*law_));
  }
  template <int Order>
  PerPoint<ExpandedPoint> expanded_at_centroids(const Instant& instant, const BodyCells<Order>& cells) const {
    if (!shape_.expansion) return {{ExpandedPoint{}}};
    return FreeExpansion::points(means_over_cells(cells, shape_.expansion->changes(instant)), split_of(*law_));
  }
  /// ds/dt at the end of a stage [1/s].
  PerPoint<Pack> rates_of_expansion(const LocalStage& stage) const {
    return shape_.expansion ? shape_.expansion->stretch().rates(stage) : PerPoint<Pack>{{Pack(0.0)}};
  }

  /// The power that a change of the free shape supplies at the end of a stage, a function of the pack's number and H
  /// [W/m^3]; only if the law depends on time.
  class Supply {
   public:
    Supply(const BodyLaw& of, const LocalStage& stage)
        : law_(of.shortened(instant_of(stage))),
          points_(of.expanded(instant_of(stage))),
          expansion_(of.rates_of_expansion(stage)) {
      const Activation* shortening = of.shape_.shortening.get();
      if (shortening == nullptr) return;
      shortened_ = std::make_unique<ActiveStrain>(*of.law_, *shortening, instant_of(stage));
      shortening_ = shortening->rates(stage);
    }
    Pack operator()(std::size_t n, const Tensor3<Pack>& H) const {
      const ExpandedPoint& at = points_[n];
      const Tensor3<Pack> H_e = at.strain(H);
      const Pack power = at.power(expansion_[n], law_->psi(n, H_e), law_->P(n, H_e), H_e);
      return shortened_ ? power + at.volume * shortening_[n] * shortened_->slope(n, H_e) : power;
    }

   private:
    Now law_;
    PerPoint<ExpandedPoint> points_;
    PerPoint<Pack> expansion_, shortening_;
    std::unique_ptr<ActiveStrain> shortened_;
  };
  Supply supply(const LocalStage& stage) const { return {*this, stage}; }

 private:
  /// The law in the expanded body.
  Now shortened(const Instant& instant) const {
    Now law(*law_);
    if (shape_.shortening) law.wrap<ActiveStrain>(*shape_.shortening, instant);
    return law;
  }

  std::shared_ptr<const LawField> law_;
  FreeShape shape_;
};

}  // namespace pliant
