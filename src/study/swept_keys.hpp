/// The keys that a sweep varies, and the values that each of its runs gives them.
#pragma once

#include "input/tree.hpp"
#include "study/latin_hypercube.hpp"
#include "study/sweep.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace pliant {

/// A key with the values that it is given one after another, or a range from which samples are taken.
struct SweptKey {
  std::string path;
  std::vector<InputNode> values;
  std::optional<NumberRange> range;
  std::optional<std::size_t> goes_with = {};  ///< an earlier key, whose values and this key's are taken in pairs
};

class SweptKeys {
 public:
  SweptKeys() = default;
  /// `changes` of the input `text`: a key is swept if its value is a list where the input takes none, or a range.
  /// InputError if none is, or if the options do not fit them.
  SweptKeys(const std::string& text, const std::string& file, const std::vector<Override>& changes,
            const SweepOptions& options);

  /// The changes that hold for all runs.
  const std::vector<Override>& fixed() const { return fixed_; }
  const std::vector<SweptKey>& keys() const { return keys_; }
  /// Runs x keys: every combination; the last list varies fastest, and the samples within it.
  std::vector<std::vector<InputNode>> cases() const;
  /// The last part of the key's path, or all of it if another one ends alike.
  std::string short_name(std::size_t k) const;

 private:
  void sort(const std::vector<Override>& changes, bool has_samples);
  void mark_logarithmic(const std::vector<std::string>& paths);
  /// Lets the keys vary together whose paths are given with commas between them.
  void bind(const std::string& paths);
  bool accepts(const Override& change) const;
  std::size_t count() const;

  std::string text_, file_;
  std::size_t samples_ = 1;
  std::uint64_t seed_ = 1;
  std::vector<Override> fixed_;
  std::vector<SweptKey> keys_;
};

}  // namespace pliant
