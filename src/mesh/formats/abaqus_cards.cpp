#include "mesh/formats/abaqus_cards.hpp"

#include "base/text.hpp"
#include "mesh/source_checks.hpp"

namespace pliant {
namespace {

/// The entries between commas; quotes protect commas and are removed.
std::vector<std::string> between_commas(std::string_view text) {
  std::vector<std::string> entries{""};
  bool is_quoted = false;
  for (const char c : text) {
    if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      entries.emplace_back();
    } else {
      entries.back() += c;
    }
  }
  for (std::string& entry : entries) entry = std::string(trimmed(entry));
  return entries;
}

/// Keywords and names of parameters may have any blanks.
std::string normal_name(std::string_view text) {
  std::string name;
  for (const char c : in_capitals(text)) {
    if (c != ' ' && c != '\t') name += c;
  }
  return name;
}

}  // namespace

std::string AbaqusCard::value(const std::string& parameter) const {
  const auto found = parameters.find(parameter);
  return found == parameters.end() ? "" : found->second;
}

bool AbaqusCards::next_line() {
  if (is_waiting_) {
    is_waiting_ = false;
    return true;
  }
  while (in_.next()) {
    if (!trimmed(in_.text()).empty() && !in_.text().starts_with("**")) return true;
  }
  return false;
}

bool AbaqusCards::next(AbaqusCard& card) {
  while (next_line()) {
    if (!in_.text().starts_with('*')) continue;
    std::string text(in_.text().substr(1));
    const std::size_t line = in_.number();
    while (text.ends_with(',') && next_line()) {
      if (in_.text().starts_with('*')) {
        is_waiting_ = true;
        break;
      }
      text += in_.text();
    }
    const auto entries = between_commas(text);
    card = {normal_name(entries.front()), {}, line};
    for (std::size_t i = 1; i < entries.size(); ++i) {
      const std::size_t sign = entries[i].find('=');
      std::string value = sign == std::string::npos ? "" : std::string(trimmed(entries[i].substr(sign + 1)));
      require_plain_name(value);
      card.parameters[normal_name(entries[i].substr(0, sign))] = std::move(value);
    }
    if (card.keyword != "INCLUDE") return true;
    if (card.value("INPUT").empty()) fail("*INCLUDE needs a file: INPUT=FILE");
    in_.include(card.value("INPUT"));
  }
  return false;
}

bool AbaqusCards::next_data(std::vector<std::string>& entries) {
  if (!next_line()) return false;
  if (in_.text().starts_with('*')) {
    is_waiting_ = true;
    return false;
  }
  entries = between_commas(in_.text());
  continues_ = entries.size() > 1 && entries.back().empty();
  if (continues_) entries.pop_back();
  return true;
}

std::size_t AbaqusCards::label(const std::string& entry, const char* what) const {
  const auto number = integer_in(entry);
  if (!number || *number < 1) fail(std::string(what) + " is expected here, not " + in_quotes(entry));
  return static_cast<std::size_t>(*number);
}

double AbaqusCards::real(const std::string& entry, const char* what) const {
  const auto number = real_in(entry);
  if (!number) fail(std::string(what) + " is expected here, not " + in_quotes(entry));
  return *number;
}

}  // namespace pliant
