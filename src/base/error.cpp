#include "base/error.hpp"

namespace pliant {
namespace {

std::string joined(const std::vector<Diagnostic>& diagnostics) {
  std::string text;
  for (const auto& d : diagnostics) {
    if (!text.empty()) text += '\n';
    text += to_string(d);
  }
  return text;
}

}  // namespace

std::string to_string(const Location& where) {
  std::string text = where.file;
  if (where.line > 0) text += ":" + std::to_string(where.line);
  if (where.line > 0 && where.column > 0) text += ":" + std::to_string(where.column);
  return text;
}

Diagnostic note(std::string message) {
  return {Severity::note, {}, std::move(message)};
}

std::string to_string(const Diagnostic& diagnostic) {
  const std::string where = to_string(diagnostic.where);
  return where.empty() ? diagnostic.message : where + ": " + diagnostic.message;
}

InputError::InputError(std::vector<Diagnostic> diagnostics)
    : std::runtime_error(joined(diagnostics)), diagnostics_(std::move(diagnostics)) {}

}  // namespace pliant
