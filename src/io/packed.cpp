#include "io/packed.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
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
  uLongf size = compressBound(bytes.size());
  std::vector<unsigned char> deflated(size);
  const auto* source = reinterpret_cast<const Bytef*>(bytes.data());
  if (compress2(deflated.data(), &size, source, bytes.size(), Z_BEST_COMPRESSION) != Z_OK) {
    throw std::runtime_error("zlib cannot deflate");
  }
  return base64(std::span(deflated).first(size));
}

std::uint16_t Quantisation::operator()(double value) const {
  const double share = (value - low) / (high - low);
  return share > 0.0 ? static_cast<std::uint16_t>(std::lround(std::min(share, 1.0) * levels)) : std::uint16_t{0};
}

void PackedRows::append(std::span<const std::uint16_t> row) {
  assert(row.size() == before_.size());
  std::uint16_t left = 0, left_before = 0;
  for (std::size_t v = 0; v < row.size(); ++v) {
    const auto predicted = static_cast<std::uint16_t>(before_[v] + left - left_before);
    const auto r = static_cast<std::int16_t>(static_cast<std::uint16_t>(row[v] - predicted));
    const auto coded = static_cast<std::uint16_t>(r >= 0 ? 2 * r : -2 * r - 1);
    low_.push_back(static_cast<std::byte>(coded & 0xff));
    high_.push_back(static_cast<std::byte>(coded >> 8));
    left_before = before_[v];
    left = before_[v] = row[v];
  }
}

std::string PackedRows::text() const {
  std::vector<std::byte> bytes = low_;
  bytes.insert(bytes.end(), high_.begin(), high_.end());
  return packed_text(bytes);
}

}  // namespace pliant
