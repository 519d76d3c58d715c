#include "solver/bdf_points.hpp"

#include <algorithm>
#include <string>

namespace pliant {

void BdfPoints::push(const StateView& point) {
  if (size_ == capacity_) {
    std::rotate(points_.begin(), points_.begin() + 1, points_.end());
    --size_;
  }
  if (size_ < points_.size()) {
    points_[size_].assign(point);
  } else {
    points_.emplace_back(point);
  }
  ++size_;
}

void BdfPoints::keep(Archive& archive, const StateView& like) {
  archive.number("size", size_);
  while (points_.size() < size_) points_.emplace_back(like);
  for (std::size_t i = 0; i < size_; ++i) {
    const Archive::Section section(archive, std::to_string(i));
    points_[i].keep(archive);
  }
}

}  // namespace pliant
