#include "petsc/session.hpp"

#include <cstdlib>

#include <gtest/gtest.h>

namespace pliant {
namespace {

// Processes that Pliant starts, such as the runs of a sweep on several ranks, choose for themselves.
TEST(Session, LeavesNothingForOtherProcesses) {
  for (const char* name :
       {"OMPI_MCA_ess_singleton_isolated", "OMPI_MCA_orte_create_session_dirs", "OMPI_MCA_pml", "OMPI_MCA_btl"}) {
    EXPECT_EQ(std::getenv(name), nullptr) << name;
  }
}

}  // namespace
}  // namespace pliant
