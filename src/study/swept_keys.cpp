#include "study/swept_keys.hpp"

#include "input/input.hpp"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace pliant {
namespace {

constexpr std::size_t most_runs = 1000;

InputError refusal(const std::string& why) {
  return {{"pliant sweep", 0, 0}, why};
}

std::optional<NumberRange> range_of(const Override& change, const InputNode& value) {
  if (value.kind != InputNode::Kind::scalar) return std::nullopt;
  try {
    return parse_range(value.text);
  } catch (const std::invalid_argument& error) {
    throw InputError({fmt::format("--set {}={}", change.path, change.value), 0, 0}, error.what());
  }
}

}  // namespace

SweptKeys::SweptKeys(const std::string& text, const std::string& file, const std::vector<Override>& changes,
                     const SweepOptions& options)
    : text_(text), file_(file), samples_(static_cast<std::size_t>(std::max(options.samples, 1))), seed_(options.seed) {
  sort(changes, options.samples > 0);
  mark_logarithmic(options.logarithmic);
  for (const std::string& paths : options.together) bind(paths);
}

void SweptKeys::sort(const std::vector<Override>& changes, bool has_samples) {
  std::vector<std::pair<const Override*, InputNode>> lists;
  for (const Override& change : changes) {
    InputNode value = value_of(change);
    if ((value.kind == InputNode::Kind::list && !value.children.empty()) || range_of(change, value)) {
      lists.emplace_back(&change, std::move(value));
    } else {
      fixed_.push_back(change);
    }
  }
  for (const auto& [change, value] : lists) {
    if (const auto range = range_of(*change, value)) {
      keys_.push_back({change->path, {}, range});
    } else if (accepts(*change)) {
      fixed_.push_back(*change);
    } else {
      keys_.push_back({change->path, value.children, {}});
    }
  }
  for (auto later = keys_.begin(); later != keys_.end(); ++later) {
    const auto is_replaced = [&](const SweptKey& key) { return (key.path + '.').starts_with(later->path + '.'); };
    const auto lost = std::find_if(keys_.begin(), later, is_replaced);
    if (lost == later) continue;
    throw refusal(fmt::format("the values of '{}' would replace those of '{}' before it; sweep one of them alone",
                              later->path, lost->path));
  }
  if (keys_.empty()) {
    throw refusal("nothing varies: give a key a list of values, e.g. --set 'time.step=[10 ms, 5 ms, 2 ms]'");
  }
  const auto ranged = std::ranges::find_if(keys_, [](const SweptKey& key) { return key.range.has_value(); });
  if (ranged != keys_.end() && !has_samples) {
    throw refusal(
        fmt::format("'{}' has a range: say how many values to take from it, e.g. --samples 20", ranged->path));
  }
  if (ranged == keys_.end() && has_samples) {
    throw refusal("--samples takes values from ranges, and no key has one, e.g. --set bodies.0.density=900..1100");
  }
}

void SweptKeys::mark_logarithmic(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    const auto key = std::ranges::find_if(keys_, [&](const SweptKey& k) { return k.path == path && k.range; });
    if (key == keys_.end()) {
      throw InputError({"--logarithmic " + path, 0, 0}, "this key has no range, as in --set KEY=LOW..HIGH");
    }
    if (key->range->low <= 0.0) {
      throw InputError({"--logarithmic " + path, 0, 0}, "both ends of the range must be positive");
    }
    key->range->is_logarithmic = true;
  }
}

void SweptKeys::bind(const std::string& paths) {
  const auto refuse = [&](const std::string& why) { return InputError({"--together " + paths, 0, 0}, why); };
  std::vector<std::size_t> group;
  std::stringstream stream(paths);
  for (std::string path; std::getline(stream, path, ',');) {
    const auto key = std::ranges::find_if(keys_, [&](const SweptKey& k) { return k.path == path && !k.range; });
    if (key == keys_.end()) {
      throw refuse(fmt::format("'{}' has no list of values, as in --set {}=[VALUE, VALUE]", path, path));
    }
    const auto place = static_cast<std::size_t>(key - keys_.begin());
    const auto is_bound = [&](const SweptKey& k) { return k.goes_with == place; };
    if (key->goes_with || std::ranges::any_of(keys_, is_bound) || std::ranges::find(group, place) != group.end()) {
      throw refuse(fmt::format("'{}' is named twice", path));
    }
    group.push_back(place);
  }
  if (group.size() < 2) throw refuse("give the keys that vary together, as in --together KEY,KEY");
  const std::size_t first = *std::ranges::min_element(group);
  for (const std::size_t k : group) {
    if (keys_[k].values.size() != keys_[first].values.size()) {
      throw refuse(fmt::format("'{}' has {} values and '{}' has {}: keys that vary together need as many values each",
                               keys_[first].path, keys_[first].values.size(), keys_[k].path, keys_[k].values.size()));
    }
    if (k != first) keys_[k].goes_with = first;
  }
}

bool SweptKeys::accepts(const Override& change) const {
  try {
    (void)read_input(text_, file_, {change});
    return true;
  } catch (const InputError&) {
    return false;
  }
}

std::size_t SweptKeys::count() const {
  std::size_t count = samples_;
  for (const SweptKey& key : keys_) {
    count *= key.range || key.goes_with ? 1 : key.values.size();
    if (count > most_runs) throw refusal(fmt::format("the sweep has more than {} runs: sweep fewer values", most_runs));
  }
  return count;
}

std::vector<std::vector<InputNode>> SweptKeys::cases() const {
  const auto num_ranges = std::ranges::count_if(keys_, [](const SweptKey& key) { return key.range.has_value(); });
  const auto points = latin_hypercube(samples_, static_cast<std::size_t>(num_ranges), seed_);
  std::vector<std::vector<InputNode>> cases(count(), std::vector<InputNode>(keys_.size()));
  for (std::size_t number = 0; number < cases.size(); ++number) {
    std::size_t rest = number / samples_, range = static_cast<std::size_t>(num_ranges);
    std::vector<std::size_t> chosen(keys_.size());
    for (std::size_t k = keys_.size(); k-- > 0;) {
      const SweptKey& key = keys_[k];
      if (key.range) {
        cases[number][k] = value_of({key.path, key.range->at(points[number % samples_][--range])});
      } else if (!key.goes_with) {
        chosen[k] = rest % key.values.size();
        rest /= key.values.size();
      }
    }
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      if (!keys_[k].range) cases[number][k] = keys_[k].values[chosen[keys_[k].goes_with.value_or(k)]];
    }
  }
  return cases;
}

std::string SweptKeys::short_name(std::size_t k) const {
  const auto last = [](const std::string& path) { return path.substr(path.rfind('.') + 1); };
  const std::string name = last(keys_[k].path);
  const auto same = std::ranges::count_if(keys_, [&](const SweptKey& key) { return last(key.path) == name; });
  return same == 1 ? name : keys_[k].path;
}

}  // namespace pliant
