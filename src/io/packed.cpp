#include "io/packed.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <zlib.h>

namespace pliant {
namespace {

std::string base64(std::span<const unsigned char> bytes) {
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
  }
  return text;
}

}  // namespace

std::string packed_text(std::span<const std::byte> bytes) {
  z_stream stream{};
  // Level 9 takes five times as long for 3 % less. For the small, nearly random numbers that predictions leave, zlib
  // should look only for longer repetitions.
  constexpr int level = 7, largest_window = 15, most_memory = 9;
  if (deflateInit2(&stream, level, Z_DEFLATED, largest_window, most_memory, Z_FILTERED) != Z_OK) {
    throw std::runtime_error("zlib cannot compress the data");
  }
  std::vector<unsigned char> deflated(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(bytes.data()));  // zlib only reads it
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = deflated.data();
  stream.avail_out = static_cast<uInt>(deflated.size());
  const int result = deflate(&stream, Z_FINISH);
  deflateEnd(&stream);
  if (result != Z_STREAM_END) throw std::runtime_error("zlib cannot compress the data");
  return base64(std::span(deflated).first(stream.total_out));
}

std::uint16_t Quantisation::operator()(double value) const {
  const double share = (value - low) / (high - low);
  return share > 0.0 ? static_cast<std::uint16_t>(std::lround(std::min(share, 1.0) * levels)) : std::uint16_t{0};
}

EarlierNeighbours::EarlierNeighbours(std::size_t num_vertices, std::span<const std::int32_t> triangles)
    : first(num_vertices + 1, 0) {
  const auto visit = [&](auto&& side) {
    for (std::size_t corner = 0; corner < triangles.size(); ++corner) {
      const auto from = triangles[corner], to = triangles[corner % 3 == 2 ? corner - 2 : corner + 1];
      if (from < to) side(from, static_cast<std::size_t>(to));
    }
  };
  visit([&](std::int32_t, std::size_t to) { ++first[to + 1]; });
  for (std::size_t v = 0; v < num_vertices; ++v) {
    if (v > 0 && first[v + 1] == 0) first[v + 1] = 1;
    first[v + 1] += first[v];
  }
  vertices.resize(first.back());
  for (std::size_t v = 1; v < num_vertices; ++v) vertices[first[v]] = static_cast<std::int32_t>(v - 1);
  std::vector<std::size_t> end(first.begin(), first.end() - 1);
  visit([&](std::int32_t from, std::size_t to) { vertices[end[to]++] = from; });
}

void PackedRows::append(std::vector<std::uint16_t> row) {
  assert(row.size() + 1 == neighbours_.first.size());
  rows_.push_back(std::move(row));
}

std::vector<std::uint16_t> PackedRows::coded(int order) const {
  const std::size_t size = neighbours_.first.size() - 1;
  std::vector<std::uint16_t> result;
  result.reserve(rows_.size() * size);
  std::vector<int> change(size);  // q - p
  for (std::size_t f = 0; f < rows_.size(); ++f) {
    for (std::size_t v = 0; v < size; ++v) {
      int predicted = f > 0 ? rows_[f - 1][v] : 0;
      if (order == 2 && f > 1) predicted += rows_[f - 1][v] - rows_[f - 2][v];
      change[v] = rows_[f][v] - predicted;
      int sum = 0;
      for (std::size_t k = neighbours_.first[v]; k < neighbours_.first[v + 1]; ++k)
        sum += change[neighbours_.vertices[k]];
      const auto count = static_cast<int>(neighbours_.first[v + 1] - neighbours_.first[v]);
      const int mean = count > 0 ? static_cast<int>(std::floor(static_cast<double>(2 * sum + count) / (2 * count))) : 0;
      const auto r = static_cast<std::int16_t>(change[v] - mean);
      result.push_back(static_cast<std::uint16_t>(r >= 0 ? 2 * r : -2 * r - 1));
    }
  }
  return result;
}

std::string PackedRows::text() const {
  const auto num_bits = [](const std::vector<std::uint16_t>& numbers) {
    return std::transform_reduce(numbers.begin(), numbers.end(), std::size_t{0}, std::plus<>(),
                                 [](std::uint16_t x) { return static_cast<std::size_t>(std::bit_width(x)); });
  };
  int order = 1;
  auto numbers = coded(order);
  if (rows_.size() > 2) {
    auto other = coded(2);
    if (num_bits(other) < num_bits(numbers)) {
      order = 2;
      numbers = std::move(other);
    }
  }
  std::vector<std::byte> bytes{static_cast<std::byte>(order)};
  bytes.reserve(1 + 2 * numbers.size());
  for (const auto x : numbers) bytes.push_back(static_cast<std::byte>(x & 0xff));
  for (const auto x : numbers) bytes.push_back(static_cast<std::byte>(x >> 8));
  return packed_text(bytes);
}

}  // namespace pliant
