#include "app/events.hpp"

#include "app/input_schema.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace pliant {
namespace {

void collect(const Expression& formula, std::vector<const Expression*>& into) {
  into.push_back(&formula);
}
template <class T>
void collect(const std::optional<T>& value, std::vector<const Expression*>& into) {
  if (value) collect(*value, into);
}
template <class T, std::size_t N>
void collect(const std::array<T, N>& values, std::vector<const Expression*>& into) {
  for (const T& value : values) collect(value, into);
}

/// Events that are nearer than this part of a step are one, as for StepControl.
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
  for (const Expression* formula : driving_formulas(config)) {
    for (const double t : formula->kinks(time.end, interval)) kinks.push_back({t, formula});
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

std::vector<const Expression*> driving_formulas(const Config& config) {
  std::vector<const Expression*> all;
  for (const BodyConfig& body : config.bodies) {
    if (!body.active) continue;
    collect(body.active->stress, all);
    collect(body.active->shortening, all);
  }
  for (const ConstraintConfig& c : config.constraints) {
    collect(c.displacement, all);
    collect(c.value, all);
    collect(c.difference, all);
    collect(c.rigid.translation, all);
    collect(c.rigid.rotation.angle, all);
  }
  for (const LoadConfig& load : config.loads) {
    collect(load.value, all);
    collect(load.pressure, all);
  }
  for (const CavityConfig& cavity : config.cavities) {
    collect(cavity.pressure, all);
    if (cavity.gas) collect(cavity.gas->amount, all);
    if (!cavity.liquid) continue;
    collect(cavity.liquid->added_volume, all);
    collect(cavity.liquid->flow, all);
  }
  if (!config.contact) return all;
  for (const ObstacleConfig& o : config.contact->obstacles) {
    if (!o.motion) continue;
    collect(o.motion->translate, all);
    if (o.motion->rotate) collect(o.motion->rotate->angle, all);
  }
  return all;
}

Events events_of(const Config& config) {
  Events events;
  if (config.time.method.value == static_method || !(config.time.step > 0.0) || !(config.time.end > 0.0)) return events;
  events.times = config.time.events;
  const std::vector<Kink> kinks = kinks_of(config);
  if (kinks.empty()) return events;
  // Each costs a step, and past states; two steps between them are the least.
  constexpr double always_taken = 50.0;
  const double most = std::max(always_taken, 0.5 * config.time.end / config.time.step);
  if (static_cast<double>(kinks.size()) > most) {
    events.warnings.push_back(
        fmt::format("{}: formulas of t have {} kinks or jumps, at {}: too many for steps to end at all of them; take "
                    "shorter steps, "
                    "or name those that matter in 'time.events'",
                    config.file, kinks.size(), in_words(kinks)));
    return events;
  }
  std::ranges::transform(kinks, std::back_inserter(events.times), &Kink::time);
  std::ranges::sort(events.times);
  events.notices.push_back(
      fmt::format("formulas of t have kinks or jumps; steps end there, as at 'time.events': {}", in_words(kinks)));
  return events;
}

}  // namespace pliant
