// A fuzzer of libFuzzer for the target that PLIANT_FUZZ_TARGET names.
#include "fuzz/targets.hpp"
#include "petsc/session.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>

// The names are libFuzzer's.
// NOLINTBEGIN(readability-identifier-naming)
extern "C" int LLVMFuzzerInitialize(int*, char*** arguments) {
  static const auto session = std::make_unique<pliant::Session>((*arguments)[0], std::vector<std::string>{});
  return session == nullptr ? 1 : 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  pliant::fuzz::PLIANT_FUZZ_TARGET({reinterpret_cast<const char*>(data), size});
  return 0;
}
// NOLINTEND(readability-identifier-naming)
