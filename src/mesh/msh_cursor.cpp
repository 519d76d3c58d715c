#include "mesh/msh_cursor.hpp"

#include "base/text.hpp"
#include "mesh/source_checks.hpp"

#include <charconv>
#include <cstdlib>

namespace pliant {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\t' || c == '\r';
}

/// A word of the file in quotes, shortened for a message.
std::string shown(std::string_view word) {
  constexpr std::size_t longest = 30;
  std::string text = excerpt(word, longest);
  for (char& c : text) {
    if (static_cast<unsigned char>(c) > 126) c = '?';
  }
  return "'" + text + "'";
}

}  // namespace

void MshCursor::fail(const std::string& message) const {
  if (encoding_ == Encoding::ascii) {
    const auto lines = std::count(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw MeshDefect("line " + std::to_string(lines + 1) + ": " + message);
  }
  throw MeshDefect("byte " + std::to_string(at_) + ": " + message);
}

void MshCursor::fail_at_end(const std::string& where) const {
  fail("the file ends " + where + ": it is truncated; write or copy it again");
}

void MshCursor::fail_as_damaged(const std::string& why) const {
  fail(why + ": the file is damaged; write or copy it again");
}

void MshCursor::reject_count(const char* what, const std::string& found) const {
  fail(std::string("the file says ") + what + " is " + found + ", but " + std::to_string(remaining()) +
       " bytes follow: it is truncated or damaged; write or copy it again");
}

std::string_view MshCursor::word() {
  while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
  const std::size_t begin = at_;
  while (at_ < bytes_.size() && !is_space(bytes_[at_])) ++at_;
  return bytes_.substr(begin, at_ - begin);
}

std::string MshCursor::quoted(const char* what) {
  while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
  const std::size_t end =
      at_ < bytes_.size() && bytes_[at_] == '"' ? bytes_.find('"', at_ + 1) : std::string_view::npos;
  if (end == std::string_view::npos) fail(std::string(what) + " is expected here in double quotes");
  std::string text(bytes_.substr(at_ + 1, end - at_ - 1));
  try {
    require_plain_name(text);
  } catch (const MeshDefect& defect) {
    fail(defect.what());
  }
  at_ = end + 1;
  return text;
}

std::string_view MshCursor::line() {
  const std::size_t begin = at_;
  const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
  at_ = std::min(end + 1, bytes_.size());
  std::string_view text = bytes_.substr(begin, end - begin);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

bool MshCursor::skip_past(std::string_view text) {
  const std::size_t found = bytes_.find(text, at_);
  if (found == std::string_view::npos) return false;
  at_ = found + text.size();
  return true;
}

std::int64_t MshCursor::integer(const char* what, std::int64_t lower, std::int64_t upper) {
  std::string_view text = word();
  const std::string_view whole = text;
  if (text.empty()) fail_at_end(std::string("where ") + what + " is expected");
  if (text.front() == '+') text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < lower || value > upper) {
    fail(std::string(what) + " is expected here, not " + shown(whole));
  }
  return value;
}

double MshCursor::real(const char* what) {
  std::string_view text = word();
  const std::string_view whole = text;
  if (text.empty()) fail_at_end(std::string("where ") + what + " is expected");
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) {
    fail(std::string(what) + " is expected here, not " + shown(whole));
  }
  // Out of range: strtod returns 0 or infinity.
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(text).c_str(), nullptr);
  return value;
}

}  // namespace pliant
