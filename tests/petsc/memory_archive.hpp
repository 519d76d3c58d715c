/// An archive in memory, for tests of what objects keep.
#pragma once

#include "petsc/archive.hpp"
#include "petsc/array_view.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace pliant::test {

/// Stores first; after `turn_round` it restores, and complains of what was not stored.
class MemoryArchive final : public Archive {
 public:
  bool restores() const override { return restores_; }
  void turn_round() { restores_ = true; }
  std::size_t size() const { return stored_.size(); }

 private:
  void exchange(const std::string& path, std::span<double> x) override {
    if (restores_) {
      const auto& values = stored_.at(path);
      if (values.size() != x.size()) throw std::logic_error("another size: " + path);
      std::ranges::copy(values, x.begin());
    } else if (!stored_.try_emplace(path, x.begin(), x.end()).second) {
      throw std::logic_error("kept twice: " + path);
    }
  }
  void exchange(const std::string& path, Entries, Vec x) override {
    const ArrayView values(x);
    exchange(path, values.span());
  }

  bool restores_ = false;
  std::map<std::string, std::vector<double>> stored_;
};

}  // namespace pliant::test
