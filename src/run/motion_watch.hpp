/// What a motion shows to be wrong with its input, though every step was solved: material stretched beyond what its law
/// is for, bodies that pass through one another.
#pragma once

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

/// Nothing for a name that is no law's.
std::optional<TrustedStretches> trusted_stretches(std::string_view law);

/// Looks at states of a run. All methods but `last_words` are collective.
class MotionWatch {
 public:
  /// Both outlive the watch.
  MotionWatch(const Config& config, const Model& model);

  /// Warnings about the stretches of the state that were not given before; for every frame.
  std::vector<std::string> look(const StepRecord& record);

  /// A warning, once a run, if parts of the mesh that share no node have come to pass through one another. For every
  /// accepted step: as long as no boxes of parts meet it costs next to nothing.
  std::optional<std::string> look_for_passage(const StepRecord& record);

  /// What has become worse since it was told, at the end of the run.
  std::vector<std::string> last_words() const;

 private:
  struct Extreme {
    double stretch = 1.0, told = 1.0;
    std::array<double, 3> X{};
    double time = 0.0;
  };
  struct Body {
    Location where;  ///< of its elasticity in the input
    std::string name, law;
    TrustedStretches trusted;
    Extreme smallest, largest;
  };

  /// "t = 0.1 s"
  std::string instant(double time) const;
  std::string in_words(const Body& body, const Extreme& extreme) const;
  void look_at_stretches(double time, std::span<const double> u, std::vector<std::string>& news);
  /// "'a' and 'b'", or "two parts of 'a'".
  std::string names_of(int component, int other) const;

  const Model& model_;
  Location mesh_;  // in the input
  bool is_static_;
  bool overlap_is_known_;                  ///< and the user has been warned
  std::vector<int> bodies_of_components_;  ///< one of those that each component has
  std::vector<Body> bodies_;
  Handle<Vec> q_;
};

}  // namespace pliant
