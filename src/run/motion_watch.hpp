/// Detects input that is probably wrong although every step was solved: material stretched beyond the range of its law,
/// bodies that pass through one another, and joints far beyond their stops.
#pragma once

#include "material/stability.hpp"
#include "model/model.hpp"
#include "run/simulation.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pliant {

/// The stretches that an elastic law describes.
struct TrustedStretches {
  double low, high;
  std::string_view why;
};

/// nullopt for a name that is not that of a law.
std::optional<TrustedStretches> trusted_stretches(std::string_view law);

/// Watches the states of a run. All methods except `final_warnings` are collective.
class MotionWatch {
 public:
  /// `config` and `model` outlive the watch.
  MotionWatch(const Config& config, const Model& model);

  /// New warnings about the stretches of the state, and once per body about those at which its law is not stable; to
  /// be called for every frame.
  std::vector<std::string> look(const StepRecord& record);

  /// A warning, once per run, if parts of the mesh that share no node pass through one another. To be called for every
  /// accepted step; the cost is negligible as long as no bounding boxes of parts overlap.
  std::optional<std::string> look_for_passage(const StepRecord& record);

  /// Warnings, once per joint, about those that are far beyond their limits. To be called for every accepted step.
  std::vector<std::string> look_at_joints(const StepRecord& record);

  /// Warnings, once per tendon, about given tensions that are negative: the tendon is slack. To be called for every
  /// accepted step.
  std::vector<std::string> look_at_tendons(const StepRecord& record);

  /// At the end of the run: updates of warnings whose stretches have become worse since.
  std::vector<std::string> final_warnings() const;

 private:
  struct Extreme {
    double stretch = 1.0, told = 1.0;
    std::array<double, 3> X{};
    double time = 0.0;
  };
  struct Body {
    Location where;  ///< place of its elasticity in the input
    std::string name, law;
    TrustedStretches trusted;  ///< of the law, or those at which its material was measured
    std::string why;           ///< instead of that of `trusted`
    Extreme smallest, largest;
    std::optional<StableStretches> stable = {};  ///< where they are known and the user has not been warned
    std::optional<Expression> expansion = {};    ///< the stretch that the law does not see
  };

  struct GivenTension {
    std::string name;
    Expression tension;
    Location where;
    double largest = 0.0;
    bool is_told = false;
  };

  static Body watched(const ElasticityConfig& elasticity, const std::string& name);
  /// "t = 0.1 s"
  std::string instant(double time) const;
  /// The time, or the load factor of a static problem.
  double progress(const StepRecord& record) const { return is_static_ ? record.load_factor : record.time; }
  std::string in_words(const Body& body, const Extreme& extreme) const;
  std::string instability(const Body& body, const Extreme& extreme, double limit) const;
  void look_at_stretches(const StepRecord& record, std::span<const double> u, std::vector<std::string>& news);
  /// "'a' and 'b'", or "two parts of 'a'".
  std::string names_of(int body, int other) const;

  const Model& model_;
  Location mesh_;  // in the input
  bool is_static_;
  bool overlap_is_known_;  // the user has been warned
  std::vector<Body> bodies_;
  std::vector<char> are_beyond_;  // per joint: the user has been warned
  std::vector<GivenTension> tendons_;
};

}  // namespace pliant
