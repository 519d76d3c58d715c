// GoogleTest under MPI: every rank runs every test; rank 0 prints, other ranks print only their failures.
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "places.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

namespace {

class FailuresOnly : public testing::EmptyTestEventListener {
  void OnTestPartResult(const testing::TestPartResult& result) override {
    if (result.failed()) {
      std::fprintf(stderr, "[rank %d] %s:%d: %s\n", pliant::rank(MPI_COMM_WORLD),
                   result.file_name() != nullptr ? result.file_name() : "", result.line_number(), result.message());
    }
  }
};

}  // namespace

namespace pliant {

std::filesystem::path source_root() {
  return PLIANT_SOURCE_DIR;
}
std::filesystem::path build_root() {
  return PLIANT_BINARY_DIR;
}
bool has_time() {
  return std::getenv("PLIANT_LONG_TESTS") != nullptr;
}

}  // namespace pliant

int main(int argc, char** argv) {
  // No test sees the meshes that others, or the user, have kept.
  for (const char* place : {"XDG_CACHE_HOME", "HOME"}) unsetenv(place);
  testing::InitGoogleTest(&argc, argv);
  pliant::Session session("tests", {});
  if (pliant::rank(MPI_COMM_WORLD) != 0) {
    auto& listeners = testing::UnitTest::GetInstance()->listeners();
    delete listeners.Release(listeners.default_result_printer());
    listeners.Append(new FailuresOnly);
  }
  const bool failed = RUN_ALL_TESTS() != 0;
  return pliant::any_rank(MPI_COMM_WORLD, failed) ? 1 : 0;
}
