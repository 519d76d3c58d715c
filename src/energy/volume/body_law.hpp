/// The elastic law of a body whose fibres may shorten with time.
#pragma once

#include "energy/volume/active_strain.hpp"

#include <memory>
#include <utility>

namespace pliant {

class BodyLaw {
 public:
  /// `shortening`: active strain of the fibres, or nullptr.
  explicit BodyLaw(std::shared_ptr<const LawField> law, std::shared_ptr<const Activation> shortening = nullptr)
      : law_(std::move(law)), shortening_(std::move(shortening)) {}

  LawTraits traits() const { return law_->traits(); }
  bool depends_on_time() const { return shortening_ != nullptr; }

  /// The law at an instant. It must not outlive the object.
  class Now {
   public:
    explicit Now(const LawField& law) : law_(&law) {}
    explicit Now(std::unique_ptr<const LawField> own) : own_(std::move(own)), law_(own_.get()) {}
    const LawField* operator->() const { return law_; }
    const LawField& operator*() const { return *law_; }

   private:
    std::unique_ptr<const LawField> own_;
    const LawField* law_;
  };
  Now at(const Instant& instant) const {
    if (!shortening_) return Now(*law_);
    return Now(std::make_unique<ActiveStrain>(*law_, *shortening_, instant));
  }

  /// The power that the shortening supplies at the end of a stage, a function of the pack's number and H [W/m^3]; only
  /// if the law depends on time.
  auto supply(const LocalStage& stage) const {
    return [law = ActiveStrain(*law_, *shortening_, instant_of(stage)), rate = shortening_->rates(stage)](
               std::size_t n, const Tensor3<Pack>& H) { return rate[n] * law.slope(n, H); };
  }

 private:
  std::shared_ptr<const LawField> law_;
  std::shared_ptr<const Activation> shortening_;
};

}  // namespace pliant
