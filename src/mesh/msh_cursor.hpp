/// A position in the bytes of a .msh or .vtk file: reads words and binary numbers, and reports where they are missing.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>

namespace pliant {

/// How the numbers of a section are written.
enum class Encoding { ascii, binary, binary_swapped };

/// Reads forwards through a file held in memory. Every failure is a MeshDefect with the line (or, in binary, the byte).
class MshCursor {
 public:
  explicit MshCursor(std::string_view bytes) : bytes_(bytes) {}

  void use(Encoding encoding) { encoding_ = encoding; }
  Encoding encoding() const { return encoding_; }

  /// The next number of type T (an integer or floating-point number), in the current encoding; `what` names it in
  /// messages.
  template <class T>
  T number(const char* what) {
    if (encoding_ == Encoding::ascii) {
      if constexpr (std::is_floating_point_v<T>) {
        return static_cast<T>(real(what));
      } else {
        return static_cast<T>(integer(what, lowest<T>(), highest<T>()));
      }
    }
    if (remaining() < sizeof(T)) fail_at_end(std::string("where ") + what + " is expected");
    std::array<char, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    if (encoding_ == Encoding::binary_swapped) std::reverse(raw.begin(), raw.end());
    at_ += sizeof(T);
    return std::bit_cast<T>(raw);
  }

  /// A count of items that take at least `bytes_each` each: a count that the rest of the file cannot hold is rejected
  /// here.
  template <class T>
  std::size_t count(const char* what, std::size_t bytes_each) {
    const T n = number<T>(what);
    if (n < 0 || static_cast<std::size_t>(n) > remaining() / bytes_each) reject_count(what, std::to_string(n));
    return static_cast<std::size_t>(n);
  }

  /// The next word; empty at the end of the file.
  std::string_view word();
  /// Text between double quotes.
  std::string quoted(const char* what);
  /// The rest of the line, without its line break.
  std::string_view line();
  /// Moves behind the next occurrence of `text`; returns false, and does not move, if there is none.
  bool skip_past(std::string_view text);

  std::size_t remaining() const { return bytes_.size() - at_; }
  [[noreturn]] void fail(const std::string& message) const;
  /// Fails with "the file ends <where>", and what to do about it.
  [[noreturn]] void fail_at_end(const std::string& where) const;
  /// Fails with "<why>: the file is damaged", and what to do about it.
  [[noreturn]] void fail_as_damaged(const std::string& why) const;

 private:
  template <class T>
  static constexpr std::int64_t lowest() {
    return static_cast<std::int64_t>(std::numeric_limits<T>::lowest());
  }
  /// The upper half of 64 bits without a sign is left out.
  template <class T>
  static constexpr std::int64_t highest() {
    return sizeof(T) < 8 ? static_cast<std::int64_t>(std::numeric_limits<T>::max()) : INT64_MAX;
  }
  std::int64_t integer(const char* what, std::int64_t lower, std::int64_t upper);
  double real(const char* what);
  [[noreturn]] void reject_count(const char* what, const std::string& found) const;

  std::string_view bytes_;
  std::size_t at_ = 0;
  Encoding encoding_ = Encoding::ascii;
};

}  // namespace pliant
