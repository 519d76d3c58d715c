/// Tests that run once for every row of the table of methods.
#pragma once

#include "time/method.hpp"

#include <ostream>
#include <string>

#include <gtest/gtest.h>

namespace pliant {

/// How a failing test shows the row it ran for.
inline void PrintTo(const Method& method, std::ostream* out) {
  *out << method.name;
}

}  // namespace pliant

namespace pliant::test {

/// Derive a suite from it and instantiate that with `every_method()` and `method_name`.
class EveryMethod : public ::testing::TestWithParam<Method> {};

inline auto every_method() {
  return ::testing::ValuesIn(methods().begin(), methods().end());
}

inline std::string method_name(const ::testing::TestParamInfo<Method>& info) {
  std::string name = info.param.name;
  std::erase(name, '-');  // which a test's name must not contain
  return name;
}

}  // namespace pliant::test
