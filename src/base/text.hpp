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

/// The candidate that a misspelt `word` most likely means; nothing if none is near.
std::optional<std::string> closest(std::string_view word, std::span<const std::string> candidates);

/// " (did you mean 'x'?)" for the closest candidate, else empty.
std::string did_you_mean(std::string_view word, std::span<const std::string> candidates);

/// The items with ", " between them.
std::string joined(std::span<const std::string> items);

/// The number that the whole text spells (decimal point, optional exponent; no inf, no nan, no blanks), else nothing.
std::optional<double> parse_number(std::string_view text);

/// The shortest text that reads back as exactly this number.
std::string format_number(double value);

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// Fit for one line of a message: at most `size` bytes, control characters replaced by blanks.
std::string excerpt(std::string_view text, std::size_t size = 60);

/// Words of `text` in lines of at most `width` columns, each begun by `indent` blanks and ended by a line feed. A word
/// too long has a line of its own. ASCII.
std::string wrapped(std::string_view text, std::size_t width, std::size_t indent);

/// Byte offset of the first byte that is not UTF-8 (overlong forms and surrogates included), else nothing.
std::optional<std::size_t> first_invalid_utf8(std::string_view text);

}  // namespace pliant
