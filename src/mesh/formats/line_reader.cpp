#include "mesh/formats/line_reader.hpp"

#include "base/text.hpp"
#include "mesh/source_checks.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <filesystem>

namespace pliant {

LineReader::LineReader(const std::string& file) : file_(file) {
  sources_.push_back({"", file_contents(file), 0, 0});
  pieces_.push_back({1, "", 1});
}

bool LineReader::next() {
  while (!sources_.empty() && sources_.back().at >= sources_.back().bytes.size()) {
    sources_.pop_back();
    if (!sources_.empty()) pieces_.push_back({number_ + 1, sources_.back().name, sources_.back().line + 1});
  }
  text_ = {};
  if (sources_.empty()) return false;
  Source& in = sources_.back();
  const std::size_t end = std::min(in.bytes.find('\n', in.at), in.bytes.size());
  text_ = std::string_view(in.bytes).substr(in.at, end - in.at);
  in.at = end + 1;
  ++in.line;
  ++number_;
  while (!text_.empty() && std::isspace(static_cast<unsigned char>(text_.back())) != 0) text_.remove_suffix(1);
  if (text_.find('\0') != std::string_view::npos) fail("this is not a text: the file is binary or damaged");
  return true;
}

void LineReader::include(const std::string& file) {
  constexpr std::size_t most_levels = 16;
  if (sources_.size() >= most_levels) fail("files include one another endlessly");
  const std::filesystem::path here = sources_.back().name.empty() ? file_ : sources_.back().name;
  const std::string path = (here.parent_path() / file).string();
  try {
    require_readable(path);
    sources_.push_back({path, file_contents(path), 0, 0});
  } catch (const std::exception& e) {
    fail("cannot include " + in_quotes(path) + ": " + e.what());
  }
  pieces_.push_back({number_ + 1, path, 1});
}

std::string LineReader::place(std::size_t number) const {
  const auto after = std::ranges::upper_bound(pieces_, number, {}, &Piece::first);
  const Piece& piece = *std::prev(after == pieces_.begin() ? std::next(after) : after);
  const std::string line = "line " + std::to_string(number - piece.first + piece.line);
  return piece.name.empty() ? line : line + " of '" + piece.name + "'";
}

void LineReader::fail(std::size_t number, const std::string& message) const {
  throw MeshDefect(place(number) + ": " + message);
}

std::optional<std::int64_t> integer_in(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) text.remove_prefix(1);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> real_in(std::string_view text) {
  std::string number(trimmed(text));
  for (char& c : number) {
    if (c == 'd' || c == 'D') c = 'e';
  }
  const char* const begin = number.c_str() + (number.starts_with('+') ? 1 : 0);
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, number.c_str() + number.size(), value);
  if (end != number.c_str() + number.size() || end == begin || error == std::errc::invalid_argument) {
    return std::nullopt;
  }
  if (error == std::errc::result_out_of_range) return std::strtod(begin, nullptr);  // 0 or infinity
  return value;
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string shown = excerpt(text, longest);
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) > 126) c = '?';
  }
  return "'" + shown + "'";
}

std::string in_capitals(std::string_view text) {
  std::string capitals(text);
  for (char& c : capitals) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

}  // namespace pliant
