// What HDF5 does to its process over a damaged file stays in a child; what the work gives or throws does not. Over
// which files HDF5 dies depends on memory that it has not set; fuzzing found some. Here the work dies by itself.
#include "base/error.hpp"
#include "petsc/hdf5.hpp"

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>

#include <gtest/gtest.h>

namespace pliant::test_hdf5_in_child {
namespace {

std::string complaint(const std::function<std::string()>& work) {
  try {
    return "none: " + hdf5_in_child("result.h5", work);
  } catch (const FileError& e) {
    return std::string("file: ") + e.what();
  } catch (const std::runtime_error& e) {
    return std::string("other: ") + e.what();
  }
}

TEST(Hdf5InChild, GivesWhatTheWorkGives) {
  EXPECT_EQ(complaint([] { return std::string(); }), "none: ");
  std::string large(3 << 20, 'x');  // more than a pipe holds
  EXPECT_EQ(complaint([&] { return large; }), "none: " + large);
}

TEST(Hdf5InChild, GivesNumbersAsTheyAre) {
  struct Numbers {
    std::int64_t whole;
    double real;
  };
  const auto numbers = hdf5_in_child("result.h5", [] { return Numbers{(std::int64_t{1} << 60) + 1, 0.1}; });
  EXPECT_EQ(numbers.whole, (std::int64_t{1} << 60) + 1);
  EXPECT_EQ(numbers.real, 0.1);
  EXPECT_THROW(hdf5_in_child("result.h5", []() -> int { throw FileError("no such dataset"); }), FileError);
}

TEST(Hdf5InChild, ThrowsWhatTheWorkThrows) {
  EXPECT_EQ(complaint([]() -> std::string { throw FileError("no such dataset"); }), "file: no such dataset");
  EXPECT_EQ(complaint([]() -> std::string { throw std::logic_error("a fault"); }), "other: a fault");
}

TEST(Hdf5InChild, BlamesTheFileWhereItDies) {
  const auto die = [] {
    (void)std::raise(SIGSEGV);
    return std::string();
  };
  EXPECT_EQ(complaint(die),
            "file: 'result.h5' is damaged: the HDF5 library crashed while reading it (Segmentation fault)");
  const auto leave = []() -> std::string { std::exit(0); };
  EXPECT_EQ(complaint(leave), "file: 'result.h5' is damaged: the HDF5 library crashed while reading it (exit code 77)");
}

}  // namespace
}  // namespace pliant::test_hdf5_in_child
