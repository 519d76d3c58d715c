/// Small helpers for text that users write and read.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace pliant {

/// Number of insertions, deletions, replacements and swaps of neighbours that turn `a` into `b` (optimal string
/// alignment); a difference of upper and lower case alone costs nothing.
int edit_distance(std::string_view a, std::string_view b);

/// The candidate closest to a misspelt `word`, or else the only one that contains it; nothing if there is none.
std::optional<std::string> closest(std::string_view word, std::span<const std::string> candidates);

/// " (did you mean 'x'?)" for the candidates that continue the word after '_', or else the closest one; else empty.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

/// The items separated by ", ".
std::string joined(std::span<const std::string> items);

/// The number that the whole text spells (decimal point, optional exponent; no inf, no nan, no blanks), else nothing.
std::optional<double> parse_number(std::string_view text);

/// The shortest text that reads back as exactly this number.
std::string format_number(double value);

/// The text without leading and trailing blanks.
std::string_view trimmed(std::string_view text);

/// The text shortened for one line of a message: at most `size` bytes, control characters replaced by blanks.
std::string excerpt(std::string_view text, std::size_t size = 60);

/// Wraps `text` into lines of at most `width` columns, each indented by `indent` blanks and ended by a line feed. A
/// longer word has a line of its own. ASCII.
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent);

/// Byte offset of the first byte that is not valid UTF-8 (overlong forms and surrogates included), else nothing.
std::optional<std::size_t> first_invalid_utf8(std::string_view text);

}  // namespace pliant
