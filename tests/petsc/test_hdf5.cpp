// What a file claims to hold is compared with its length before anybody makes room for it.
#include "base/error.hpp"
#include "petsc/hdf5.hpp"

#include <array>
#include <functional>
#include <string>

#include <gtest/gtest.h>

namespace pliant::test_hdf5 {
namespace {

Hdf5Handle file_in_memory() {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "choose memory");
  check_hdf5(H5Pset_fapl_core(access.get(), 1 << 16, /*backing_store=*/0), "choose memory");
  return {H5Fcreate("memory.h5", H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), H5Fclose, "create a file in memory"};
}

TEST(Hdf5, AFileHasRoomForWhatItHolds) {
  const Hdf5Handle file = file_in_memory();
  const std::array<double, 5> values{1, 2, 3, 4, 5};
  write_dataset(file.get(), "values", {5}, H5T_NATIVE_DOUBLE, values.data());
  const Hdf5Handle dataset(H5Dopen2(file.get(), "values", H5P_DEFAULT), H5Dclose, "open the dataset");
  EXPECT_NO_THROW(require_stored(dataset.get(), "read"));
  EXPECT_NO_THROW(require_room(dataset.get(), sizeof(values), "read"));
  EXPECT_THROW(require_room(dataset.get(), 1e9, "read"), FileError);
}

TEST(Hdf5, WhatWasNeverStoredIsNotRead) {
  const Hdf5Handle file = file_in_memory();
  const hsize_t size = 1'000'000'000;
  const Hdf5Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose, "make a space");
  const Hdf5Handle dataset(
      H5Dcreate2(file.get(), "empty", H5T_NATIVE_DOUBLE, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose,
      "make a dataset");
  EXPECT_THROW(require_stored(dataset.get(), "read"), FileError);
}

std::string told_by(const std::function<void()>& act) {
  try {
    const QuietHdf5 quiet;
    act();
  } catch (const FileError& e) {
    return e.what();
  }
  return "nothing";
}

TEST(Hdf5, TellsTheSystemsWordsInOneLine) {
  EXPECT_EQ(told_by([] { open_hdf5("no/such/folder/file.h5", Hdf5Mode::create); }),
            "cannot create 'no/such/folder/file.h5': No such file or directory");
  EXPECT_EQ(told_by([] { open_hdf5("/dev/full", Hdf5Mode::create, /*user_block=*/512).close("write the file"); }),
            "cannot create '/dev/full': No space left on device");
}

}  // namespace
}  // namespace pliant::test_hdf5
