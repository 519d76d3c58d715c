#include "io/packed_companions.hpp"

#include "base/error.hpp"
#include "base/limits.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace pliant {
namespace {

constexpr int levels_of_points = 65535;

void widen(Quantisation& scale, std::span<const float> values) {
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    scale.low = std::min(scale.low, value);
    scale.high = std::max(scale.high, value);
  }
}

std::string packed_numbers(std::span<const std::int64_t> numbers) {
  const std::vector<std::int32_t> short_numbers(numbers.begin(), numbers.end());
  return packed_text(std::as_bytes(std::span(short_numbers)));
}

PackedPoints at_rest(std::span<const double> points, const EarlierNeighbours& neighbours) {
  PackedPoints packed;
  packed.count = points.size() / 3;
  for (std::size_t i = 0; i < 3; ++i) {
    std::tie(packed.positions[i], packed.position_scales[i]) = packed_rows({component_of(points, i)}, neighbours);
  }
  return packed;
}

using Moves = std::vector<double> Companions::Frame::*;

void add_moves(const std::vector<const Companions::Frame*>& frames, Moves moves, const EarlierNeighbours& neighbours,
               PackedPoints& packed) {
  for (std::size_t k = 0; k < 3 && packed.count > 0; ++k) {
    std::vector<std::vector<float>> rows;
    for (const Companions::Frame* frame : frames) rows.push_back(component_of(frame->*moves, k));
    std::tie(packed.moves[k], packed.move_scales[k]) = packed_rows(rows, neighbours);
  }
}

std::vector<double> difference(std::vector<double> points, std::span<const double> from) {
  for (std::size_t i = 0; i < points.size(); ++i) points[i] -= from[i];
  return points;
}

void for_each_text(const PackedPoints& points, const AddText& add) {
  std::ranges::for_each(points.positions, add);
  std::ranges::for_each(points.moves, add);
}

}  // namespace

std::pair<std::string, Quantisation> packed_rows(const std::vector<std::vector<float>>& rows,
                                                 const EarlierNeighbours& neighbours) {
  Quantisation scale{infinity, -infinity, levels_of_points};
  for (const auto& row : rows) widen(scale, row);
  if (!(scale.low <= scale.high)) scale.low = scale.high = 0.0;
  PackedRows packed(neighbours);
  for (const auto& row : rows) {
    std::vector<std::uint16_t> quantised;
    quantised.reserve(row.size());
    for (const double value : row) quantised.push_back(scale(value));
    packed.append(std::move(quantised));
  }
  return {packed.text(), scale};
}

std::vector<float> component_of(std::span<const double> points, std::size_t component) {
  std::vector<float> x;
  for (std::size_t i = component; i < points.size(); i += 3) x.push_back(static_cast<float>(points[i]));
  return x;
}

std::string packed_triangles(std::span<const std::int32_t> triangles) {
  std::vector<std::int32_t> steps(triangles.begin(), triangles.end());
  for (std::size_t i = steps.size(); i-- > 1;) steps[i] -= steps[i - 1];
  return packed_text(std::as_bytes(std::span(steps)));
}

void for_each_text(const PackedObstacles& obstacles, const AddText& add) {
  for_each_text(obstacles.points, add);
  add(obstacles.triangles);
  add(obstacles.owners);
}

void for_each_text(const PackedMechanisms& mechanisms, const AddText& add) {
  std::ranges::for_each(mechanisms.names, add);
  for_each_text(mechanisms.points, add);
  for (const auto* text : {&mechanisms.segments, &mechanisms.parts, &mechanisms.joints, &mechanisms.tensions}) {
    add(*text);
  }
}

Companions::Companions(const ResultReader& result, const std::string& mesh) {
  if (auto obstacles = result.obstacles(mesh)) {
    given_obstacles_ = std::move(*obstacles);
    const auto& given = given_obstacles_;
    const std::vector<std::int32_t> triangles(given.triangles.begin(), given.triangles.end());
    obstacle_neighbours_ = EarlierNeighbours(given.points.size() / 3, triangles);
    obstacles_ = {given.names, at_rest(given.points, obstacle_neighbours_), packed_triangles(triangles),
                  packed_text(std::as_bytes(std::span(given.obstacles)))};
  }
  if (auto mechanisms = result.mechanisms(mesh)) {
    given_mechanisms_ = std::move(*mechanisms);
    const auto& given = given_mechanisms_;
    point_neighbours_ = EarlierNeighbours(given.points.size() / 3);
    segment_neighbours_ = EarlierNeighbours(given.parts.size());
    mechanisms_.names = given.names;
    mechanisms_.kinds = given.kinds;
    mechanisms_.points = at_rest(given.points, point_neighbours_);
    mechanisms_.segments = packed_numbers(given.segments);
    mechanisms_.parts = packed_text(std::as_bytes(std::span(given.parts)));
    mechanisms_.joints = packed_numbers(given.joints);
  }
}

Companions::Frame Companions::read(const ResultReader& result, const ResultFrame& frame) const {
  Frame read;
  if (!given_obstacles_.points.empty()) {
    auto points = result.obstacle_points(frame);
    if (points.size() != given_obstacles_.points.size()) {
      throw FileError("the obstacles of frame '" + frame.name + "' are damaged");
    }
    read.obstacle_moves = difference(std::move(points), given_obstacles_.points);
  }
  if (!given_mechanisms_.points.empty()) {
    MechanismState state = result.mechanism_state(frame, given_mechanisms_);
    read.mechanism_moves = difference(std::move(state.points), given_mechanisms_.points);
    read.tensions = std::move(state.tensions);
  }
  return read;
}

PackedObstacles Companions::obstacles(const std::vector<const Frame*>& frames) const {
  PackedObstacles packed = obstacles_;
  add_moves(frames, &Frame::obstacle_moves, obstacle_neighbours_, packed.points);
  return packed;
}

PackedMechanisms Companions::mechanisms(const std::vector<const Frame*>& frames) const {
  PackedMechanisms packed = mechanisms_;
  if (packed.points.count == 0) return packed;
  add_moves(frames, &Frame::mechanism_moves, point_neighbours_, packed.points);
  std::vector<std::vector<float>> rows;
  for (const Frame* frame : frames) rows.emplace_back(frame->tensions.begin(), frame->tensions.end());
  std::tie(packed.tensions, packed.tension_scale) = packed_rows(rows, segment_neighbours_);
  return packed;
}

}  // namespace pliant
