#include "model/events.hpp"

#include "base/text.hpp"
#include "input/analysis.hpp"
#include "input/loads.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace pliant {
namespace {

class Formulas {
 public:
  explicit Formulas(DrivingFormula::Kind kind, const Location& where, std::vector<DrivingFormula>& into)
      : kind_(kind), where_(where), into_(into) {}

  void add(const Expression& formula) { into_.push_back({&formula, where_, kind_}); }
  template <class T>
  void add(const std::optional<T>& value) {
    if (value) add(*value);
  }
  template <class T, std::size_t N>
  void add(const std::array<T, N>& values) {
    for (const T& value : values) add(value);
  }

  void operator()(const ActiveConfig::Stress& active) { add(active.tension); }
  void operator()(const ActiveConfig::Shortening& active) { add(active.part); }
  void operator()(const ConstraintConfig::Displacement& prescribed) { add(prescribed.value); }
  void operator()(const ConstraintConfig::Symmetry&) {}
  void operator()(const ConstraintConfig::Normal& normal) { add(normal.displacement); }
  void operator()(const ConstraintConfig::Along& along) { add(along.displacement); }
  void operator()(const ConstraintConfig::Periodic& periodic) { add(periodic.difference); }
  void operator()(const ConstraintConfig::Tied&) {}
  void operator()(const ConstraintConfig::Rigid& rigid) {
    add(rigid.translation);
    if (const auto* about = std::get_if<RotationConfig::AboutAxis>(&rigid.rotation.kind)) add(about->angle);
  }
  void operator()(const ConstraintConfig::Equation& equation) { add(equation.value); }
  void operator()(const CavityConfig::GivenPressure& pressure) { add(pressure.value); }
  void operator()(const CavityConfig::Gas& gas) { add(gas.amount); }
  void operator()(const CavityConfig::Liquid& liquid) {
    add(liquid.added_volume);
    add(liquid.flow);
  }

 private:
  DrivingFormula::Kind kind_;
  const Location& where_;
  std::vector<DrivingFormula>& into_;
};

/// Whether there are time steps, which could end at events.
bool has_steps(const Config& config) {
  return analysis_of(config) != Analysis::static_equilibrium && config.time.step > 0.0 && config.time.end > 0.0;
}

/// Events closer than this fraction of a step are one, as in StepControl.
constexpr double same = 1e-6;

struct Kink {
  double time = 0.0;
  const Expression* formula = nullptr;
};

std::vector<Kink> kinks_of(const Config& config) {
  constexpr double fewest_samples = 1e3, most_samples = 1e5;
  const TimeConfig& time = config.time;
  const double interval = std::clamp(0.25 * time.step, time.end / most_samples, time.end / fewest_samples);
  std::vector<Kink> kinks;
  for (const DrivingFormula& driving : driving_formulas(config)) {
    for (const double t : driving.formula->kinks(time.end, interval)) kinks.push_back({t, driving.formula});
  }
  std::ranges::sort(kinks, {}, &Kink::time);
  const auto repeated =
      std::ranges::unique(kinks, [&](const Kink& a, const Kink& b) { return b.time - a.time <= same * time.step; });
  kinks.erase(repeated.begin(), repeated.end());
  const auto is_given = [&](const Kink& kink) {
    return std::ranges::any_of(time.events,
                               [&](double event) { return std::abs(event - kink.time) <= same * time.step; });
  };
  std::erase_if(kinks, is_given);
  return kinks;
}

/// "t = 0.1, 0.2, 0.3 s and 5 more, the first of '...'".
std::string in_words(const std::vector<Kink>& kinks) {
  constexpr std::size_t most_shown = 5;
  std::string text = "t = ";
  for (std::size_t k = 0; k < std::min(kinks.size(), most_shown); ++k) {
    text += fmt::format("{}{:.6g}", k == 0 ? "" : ", ", kinks[k].time);
  }
  text += " s";
  if (kinks.size() > most_shown) text += fmt::format(" and {} more", kinks.size() - most_shown);
  return text +
         fmt::format("{} of '{}'", kinks.size() > 1 ? ", the first" : ",", excerpt(kinks.front().formula->text()));
}

}  // namespace

std::vector<DrivingFormula> driving_formulas(const Config& config) {
  using Kind = DrivingFormula::Kind;
  std::vector<DrivingFormula> all;
  for (const BodyConfig& body : config.bodies) {
    if (body.expansion) Formulas(Kind::force, body.expansion->where, all).add(body.expansion->stretch);
    if (!body.active) continue;
    Formulas formulas(Kind::force, body.active->where, all);
    std::visit(formulas, body.active->contraction);
  }
  for (const ConstraintConfig& c : config.constraints) {
    std::visit(Formulas(Kind::motion, c.where, all), c.kind);
  }
  for (const LoadConfig& load : config.loads) {
    Formulas formulas(Kind::force, load.where, all);
    if (const VectorExpression* vector = vector_of(load)) formulas.add(*vector);
    if (const auto* pressure = std::get_if<LoadConfig::Pressure>(&load.kind)) formulas.add(pressure->value);
  }
  for (const CavityConfig& cavity : config.cavities) {
    std::visit(Formulas(Kind::force, cavity.where, all), cavity.content);
  }
  for (const JointConfig& joint : config.joints) {
    if (joint.motion) Formulas(Kind::motion, joint.where, all).add(*joint.motion);
    if (!joint.motor) continue;
    Formulas formulas(Kind::force, joint.where, all);
    formulas.add(joint.motor->target);
    formulas.add(joint.motor->effort);
  }
  for (const TendonConfig& tendon : config.tendons) {
    Formulas formulas(Kind::force, tendon.where, all);
    if (tendon.tension) formulas.add(*tendon.tension);
    if (tendon.pull) formulas.add(*tendon.pull);
  }
  if (!config.contact) return all;
  for (const ObstacleConfig& o : config.contact->obstacles) {
    if (!o.motion) continue;
    Formulas formulas(Kind::motion, o.where, all);
    formulas.add(o.motion->translate);
    if (o.motion->rotate) formulas.add(o.motion->rotate->angle);
  }
  return all;
}

std::vector<ReplaceableFormula> replaceable_formulas(Config& config) {
  std::vector<ReplaceableFormula> result;
  for (const DrivingFormula& driving : driving_formulas(config)) {
    const auto is_flow = [&](const CavityConfig& cavity) {
      const auto* liquid = std::get_if<CavityConfig::Liquid>(&cavity.content);
      return liquid != nullptr && &liquid->flow == driving.formula;
    };
    if (std::ranges::any_of(config.cavities, is_flow)) continue;
    const bool is_of_joint = std::ranges::any_of(
        config.joints, [&](const JointConfig& joint) { return joint.motion && &*joint.motion == driving.formula; });
    // A part of this config, which may change.
    result.push_back({const_cast<Expression*>(driving.formula), driving.kind, is_of_joint});
  }
  return result;
}

std::vector<Diagnostic> warnings_about_moving_kinks(const Config& config, const std::array<double, 6>& bounds) {
  struct Kink {
    double time;
    std::array<double, 3> X;
  };
  constexpr double samples = 1e3;
  std::vector<Diagnostic> warnings;
  if (!has_steps(config)) return warnings;
  for (const auto& [formula, where, kind] : driving_formulas(config)) {
    if (kind != DrivingFormula::Kind::motion || !formula->depends_on_space()) continue;
    std::vector<Kink> kinks;
    for (int place = 0; place < 27; ++place) {
      std::array<double, 3> X{};
      for (std::size_t i = 0, rest = static_cast<std::size_t>(place); i < 3; ++i, rest /= 3) {
        X[i] = bounds[i] + 0.5 * static_cast<double>(rest % 3) * (bounds[i + 3] - bounds[i]);
      }
      for (const double t : formula->kinks_at(X, config.time.end, config.time.end / samples)) kinks.push_back({t, X});
    }
    if (kinks.empty()) continue;
    const auto at = [](const Kink& kink) {
      return fmt::format("t = {:.4g} s at ({:.4g}, {:.4g}, {:.4g})", kink.time, kink.X[0], kink.X[1], kink.X[2]);
    };
    const auto [first, last] = std::ranges::minmax_element(kinks, {}, &Kink::time);
    warnings.push_back(
        {Severity::warning, where,
         fmt::format(
             "the motion prescribed by '{}' has kinks or jumps whose times depend on the position, such as {}{}: "
             "steps do not end there, so every method is of first order at best, and velocities may be wrong by the "
             "jump "
             "at the kink; list the times that matter in 'time.events', or write a formula without kinks, such as "
             "0.5*(a + b - sqrt((a - b)^2 + c^2)) with a small c instead of min(a, b)",
             excerpt(formula->text()), at(*first), last->time > first->time ? " and " + at(*last) : "")});
  }
  return warnings;
}

Events events_of(const Config& config) {
  Events events;
  if (!has_steps(config)) return events;
  events.times = config.time.events;
  std::vector<Kink> kinks = kinks_of(config);
  // Steps end at the end in any case. That it is an event matters to the last one, and to a run that is resumed from
  // there.
  const auto is_end = [&](const Kink& kink) { return kink.time >= config.time.end - same * config.time.step; };
  const bool is_at_end = std::erase_if(kinks, is_end) > 0;
  // Each event costs a step and the past states; at least two steps must lie between them.
  constexpr double always_taken = 50.0;
  const double most = std::max(always_taken, 0.5 * config.time.end / config.time.step);
  if (static_cast<double>(kinks.size()) > most) {
    events.diagnostics.push_back(
        {Severity::warning,
         {config.file, 0, 0},
         fmt::format("formulas of t have {} kinks or jumps, at {}: too many for steps to end at all of them; take "
                     "shorter steps, "
                     "or list those that matter in 'time.events'",
                     kinks.size(), in_words(kinks))});
  } else if (!kinks.empty()) {
    std::ranges::transform(kinks, std::back_inserter(events.times), &Kink::time);
    std::ranges::sort(events.times);
    events.diagnostics.push_back(note(
        fmt::format("formulas of t have kinks or jumps; steps end there, as at 'time.events': {}", in_words(kinks))));
  }
  if (is_at_end) events.times.push_back(config.time.end);
  return events;
}

}  // namespace pliant
