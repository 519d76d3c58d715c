#include "petsc/kept_in_memory.hpp"

#include "petsc/array_view.hpp"

#include <algorithm>
#include <cassert>

namespace pliant {
namespace {

class Storing final : public Archive {
 public:
  explicit Storing(std::vector<std::vector<double>>& items) : items_(items) {}
  bool restores() const override { return false; }

 protected:
  void exchange(const std::string& /*path*/, std::span<double> x) override { items_.emplace_back(x.begin(), x.end()); }
  void exchange(const std::string& path, Entries /*entries*/, Vec x) override {
    const ArrayView values(x);
    exchange(path, values.span());
  }

 private:
  std::vector<std::vector<double>>& items_;
};

class Restoring final : public Archive {
 public:
  explicit Restoring(const std::vector<std::vector<double>>& items) : items_(items) {}
  bool restores() const override { return true; }

 protected:
  void exchange(const std::string& /*path*/, std::span<double> x) override {
    assert(items_[next_].size() == x.size());
    std::ranges::copy(items_[next_++], x.begin());
  }
  void exchange(const std::string& path, Entries /*entries*/, Vec x) override {
    const ArrayView values(x);
    exchange(path, values.span());
  }

 private:
  const std::vector<std::vector<double>>& items_;
  std::size_t next_ = 0;
};

}  // namespace

KeptInMemory::KeptInMemory(const Keep& keep) {
  Storing archive(items_);
  keep(archive);
}

void KeptInMemory::restore(const Keep& keep) const {
  Restoring archive(items_);
  keep(archive);
}

}  // namespace pliant
