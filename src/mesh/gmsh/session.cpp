#include "mesh/gmsh/session.hpp"

#include "mesh/serial_mesh.hpp"

#include <algorithm>
#include <exception>
#include <functional>
#include <set>
#include <string_view>
#include <vector>

#include <gmsh.h>

namespace pliant {
namespace {

constexpr char error_prefix[] = "Error: ";

constexpr std::string_view unknown_variable = "Unknown variable '";

/// What to do about an error that names a variable which the script has not defined; else empty.
std::string about_unknown_variable(const std::string& error) {
  const std::size_t at = error.find(unknown_variable);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + unknown_variable.size();
  const std::string name = error.substr(begin, error.find('\'', begin) - begin);
  return ": correct its name, or define it above that line ('" + name + " = ...;')";
}

// gmsh's log lines read "Level: text".
std::vector<std::string> logged_errors() {
  std::vector<std::string> log;
  gmsh::logger::get(log);
  std::vector<std::string> errors;
  std::set<std::string> seen;
  for (const auto& line : log) {
    if (line.rfind(error_prefix, 0) != 0) continue;
    std::string text = line.substr(sizeof error_prefix - 1);
    if (text.ends_with("OpenCASCADE geometry kernel")) text += ": begin the script with SetFactory(\"OpenCASCADE\");";
    text += about_unknown_variable(text);
    if (seen.insert(text).second) errors.push_back(std::move(text));
  }
  // What follows from variables that are not known says nothing more.
  const auto is_cause = [](const std::string& error) { return error.find(unknown_variable) != std::string::npos; };
  if (std::ranges::any_of(errors, is_cause)) std::erase_if(errors, std::not_fn(is_cause));
  return errors;
}

// gmsh throws strings and integers besides exceptions; empty when `work` returned.
std::string thrown_by(const std::function<void()>& work) {
  try {
    work();
    return "";
  } catch (const MeshDefect&) {
    throw;
  } catch (const std::string& text) {
    return text.empty() ? "unknown error" : text;
  } catch (const char* text) {
    return text;
  } catch (int code) {
    return "error " + std::to_string(code);
  } catch (const std::bad_alloc&) {
    return "out of memory";
  } catch (const std::exception& e) {
    return e.what();
  }
}

}  // namespace

GmshSession::GmshSession() {
  gmsh::initialize(0, nullptr, false);
  gmsh::option::setNumber("General.Terminal", 0);
  // gmsh's parser does not survive an exception thrown through it: errors are read from the log.
  gmsh::option::setNumber("General.AbortOnError", 0);
  gmsh::option::setNumber("General.NumThreads", 1);  // so that every machine gives the same mesh
  gmsh::logger::start();
}

GmshSession::~GmshSession() {
  try {
    gmsh::logger::stop();
    gmsh::finalize();
  } catch (...) {  // a failure of the clean-up has no remedy
  }
}

void GmshSession::run(const std::string& doing, const std::function<void()>& work) const {
  const std::string thrown = thrown_by(work);
  std::vector<std::string> errors = logged_errors();
  if (thrown.empty() && errors.empty()) return;
  if (errors.empty()) errors.push_back(thrown);
  constexpr std::size_t shown = 5;
  std::string text = "gmsh could not " + doing + ":";
  for (std::size_t i = 0; i < errors.size() && i < shown; ++i) text += "\n  " + errors[i];
  if (errors.size() > shown) text += "\n  ... and " + std::to_string(errors.size() - shown) + " more errors";
  throw MeshDefect(text);
}

}  // namespace pliant
