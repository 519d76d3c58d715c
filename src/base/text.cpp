#include "base/text.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numeric>
#include <vector>

#include <fmt/format.h>

namespace pliant {
namespace {

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/// Length of the UTF-8 character at `at`, or 0 if there is none (Unicode 15, table 3-7).
std::size_t utf8_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  const unsigned second_low = first == 0xE0 ? 0xA0 : first == 0xF0 ? 0x90 : 0x80;
  const unsigned second_high = first == 0xED ? 0x9F : first == 0xF4 ? 0x8F : 0xBF;
  if (byte(at + 1) < second_low || byte(at + 1) > second_high) return 0;
  for (std::size_t i = 2; i < length; ++i) {
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  }
  return length;
}

std::string without_underscores(std::string_view text) {
  std::string result;
  std::ranges::copy_if(text, std::back_inserter(result), [](char c) { return c != '_'; });
  return result;
}

/// The candidate with the word in it, whatever its underscores, if there is one alone.
std::optional<std::string> only_one_with(std::string_view word, std::span<const std::string> candidates) {
  constexpr std::size_t fewest = 4;  // letters
  const std::string part = without_underscores(word);
  if (part.size() < fewest) return {};
  std::optional<std::string> found;
  for (const auto& candidate : candidates) {
    if (without_underscores(candidate).find(part) == std::string::npos) continue;
    if (found) return {};
    found = candidate;
  }
  return found;
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replace = last[j - 1] + (lower(a[i - 1]) == lower(b[j - 1]) ? 0 : 1);
      row[j] = std::min({replace, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) && lower(a[i - 2]) == lower(b[j - 1]);
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

std::optional<std::string> closest(std::string_view word, std::span<const std::string> candidates) {
  constexpr std::size_t longest = 64;  // longer words are not misspelt keys
  if (word.size() > longest) return {};
  std::optional<std::string> best;
  int best_distance = 0;
  for (const auto& candidate : candidates) {
    const int distance = edit_distance(word, candidate);
    const int tolerated = static_cast<int>(std::max(word.size(), candidate.size()) + 2) / 3;
    const bool shares_letters = distance < static_cast<int>(std::min(word.size(), candidate.size()));
    if (distance > tolerated || !shares_letters || (best && distance >= best_distance)) continue;
    best = candidate;
    best_distance = distance;
  }
  return best ? best : only_one_with(word, candidates);
}

std::string did_you_mean(std::string_view word, std::span<const std::string> candidates) {
  constexpr std::size_t most = 6;
  std::vector<std::string> longer;  // those that continue the word, as columns continue the name of a probe
  for (const std::string& candidate : candidates) {
    const bool continues =
        !word.empty() && candidate.starts_with(word) && candidate.substr(word.size()).starts_with('_');
    if (continues) longer.push_back("'" + candidate + "'");
  }
  if (longer.size() > most) {
    longer.resize(most - 1);
    longer.emplace_back("another of these");
  }
  if (longer.size() == 1) return " (did you mean " + longer.front() + "?)";
  if (!longer.empty()) {
    return fmt::format(" (did you mean {} or {}?)", joined(std::span(longer).first(longer.size() - 1)), longer.back());
  }
  const auto best = closest(word, candidates);
  return best ? " (did you mean '" + *best + "'?)" : "";
}

std::string joined(std::span<const std::string> items) {
  return fmt::format("{}", fmt::join(items, ", "));
}

std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return {};
  }
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return {};
  return value;
}

std::string format_number(double value) {
  return fmt::format("{}", value);
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string excerpt(std::string_view text, std::size_t size) {
  std::size_t end = std::min(size, text.size());
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80)
    --end;  // never cut a character
  std::string result(text.substr(0, end));
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return end < text.size() ? result + "..." : result;
}

std::string wrapped(std::string_view text, std::size_t width, std::size_t indent) {
  std::string lines;
  std::size_t column = 0;
  while (!(text = trimmed(text)).empty()) {
    const auto length = static_cast<std::size_t>(std::ranges::find_if(text, is_blank) - text.begin());
    if (column > 0 && column + 1 + length > width) {
      lines += '\n';
      column = 0;
    }
    lines += column == 0 ? std::string(indent, ' ') : " ";
    lines += text.substr(0, length);
    column += length + (column == 0 ? indent : 1);
    text.remove_prefix(length);
  }
  if (column > 0) lines += '\n';
  return lines;
}

std::optional<std::size_t> first_invalid_utf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = utf8_length(text, at);
    if (length == 0) return at;
    at += length;
  }
  return {};
}

}  // namespace pliant
