/// A mesh as a string of bytes: between processes, and on disk for this machine.
#pragma once

#include "mesh/serial_mesh.hpp"

#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace pliant {

/// Serializes values of plain types and vectors of them, one after another.
class Packer {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <class Range>
  void put_range(const Range& range) {
    put(range.size());
    bytes_.append(reinterpret_cast<const char*>(range.data()), range.size() * sizeof(typename Range::value_type));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : bytes_(bytes) {}
  std::string_view rest() const { return bytes_; }
  template <class T>
  T get() {
    T value;
    take(&value, sizeof(T));
    return value;
  }
  template <class Range>
  Range get_range() {
    const auto size = get<std::size_t>();
    if (size > bytes_.size() / sizeof(typename Range::value_type)) throw incomplete();
    Range range;
    range.resize(size);
    take(range.data(), range.size() * sizeof(typename Range::value_type));
    return range;
  }

 private:
  static std::runtime_error incomplete() { return std::runtime_error("the bytes of a mesh are incomplete"); }
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) throw incomplete();
    if (size == 0) return;  // memcpy takes no null pointers
    std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  std::string_view bytes_;
};

void pack(Packer& out, const std::vector<std::string>& texts);
std::vector<std::string> unpack_texts(Unpacker& in);

/// All but the cell data, which no geometry has.
void pack(Packer& out, const SerialMesh& mesh);
SerialMesh unpack_mesh(Unpacker& in);

}  // namespace pliant
