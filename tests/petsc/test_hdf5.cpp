// What a file claims to hold is compared with its length before anybody makes room for it.
#include "base/error.hpp"
#include "petsc/hdf5.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

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

// Two rows of three numbers, packed.
Hdf5Handle in_pieces(hid_t file, const char* name, hsize_t width, hid_t type) {
  const std::array<hsize_t, 2> sizes{2, 3}, most{2, H5S_UNLIMITED}, piece{2, width};
  const Hdf5Handle space(H5Screate_simple(2, sizes.data(), most.data()), H5Sclose, "make a space");
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, "choose pieces");
  check_hdf5(H5Pset_chunk(creation.get(), 2, piece.data()), "choose pieces");
  check_hdf5(H5Pset_deflate(creation.get(), 4), "choose pieces");
  return {H5Dcreate2(file, name, type, space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Dclose,
          "make a dataset"};
}

TEST(Hdf5, PiecesAreNotLargerThanWhatTheyArePiecesOf) {
  const Hdf5Handle file = file_in_memory();
  const auto told = [&](const char* name, hsize_t width, hid_t type) {
    const Hdf5Handle dataset = in_pieces(file.get(), name, width, type);
    return told_by([&] { require_stored(dataset.get(), "read"); });
  };
  EXPECT_EQ(told("narrow", 1, H5T_NATIVE_DOUBLE), "nothing");
  EXPECT_EQ(told("whole rows", 3, H5T_NATIVE_DOUBLE), "nothing");
  EXPECT_EQ(told("wide", 4, H5T_NATIVE_DOUBLE), "cannot read: its chunks are wider than its rows");
}

TEST(Hdf5, NumbersLieWithinTheirBytes) {
  const Hdf5Handle file = file_in_memory();
  const Hdf5Handle biased(H5Tcopy(H5T_IEEE_F64LE), H5Tclose, "copy"), shifted(H5Tcopy(H5T_STD_I32LE), H5Tclose, "copy");
  check_hdf5(H5Tset_ebias(biased.get(), 7), "change");
  check_hdf5(H5Tset_precision(shifted.get(), 31), "change");
  const std::vector<std::pair<hid_t, bool>> types{
      {H5T_IEEE_F32BE, true},   {H5T_NATIVE_DOUBLE, true},   {H5T_STD_U16BE, true}, {H5T_STD_I8LE, true},
      {H5T_NATIVE_INT64, true}, {H5T_NATIVE_LDOUBLE, false}, {biased.get(), false}, {shifted.get(), false}};
  for (std::size_t i = 0; i < types.size(); ++i) {
    const auto [type, usual] = types[i];
    const Hdf5Handle dataset = in_pieces(file.get(), std::to_string(i).c_str(), 3, type);
    const std::string told = told_by([&] { require_stored(dataset.get(), "read"); });
    EXPECT_EQ(told == "nothing", usual) << i << ": " << told;
  }
}

void make_attribute(hid_t object, const char* name, hid_t type, const void* value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose, "make a space");
  const Hdf5Handle attribute(H5Acreate2(object, name, type, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose, "make");
  check_hdf5(H5Awrite(attribute.get(), type, value), "write");
}

TEST(Hdf5, AttributesAreUsualNumbers) {
  const Hdf5Handle file = file_in_memory();
  const Hdf5Handle biased(H5Tcopy(H5T_IEEE_F64LE), H5Tclose, "copy"), shifted(H5Tcopy(H5T_STD_I64LE), H5Tclose, "copy"),
      text(H5Tcopy(H5T_C_S1), H5Tclose, "copy");
  check_hdf5(H5Tset_ebias(biased.get(), 7), "change");
  check_hdf5(H5Tset_precision(shifted.get(), 31), "change");
  check_hdf5(H5Tset_size(text.get(), sizeof(double)), "change");
  const std::array<std::pair<hid_t, bool>, 6> types{{{H5T_NATIVE_DOUBLE, true},
                                                     {H5T_IEEE_F64BE, true},
                                                     {H5T_NATIVE_INT64, true},
                                                     {biased.get(), false},
                                                     {shifted.get(), false},
                                                     {text.get(), false}}};
  const double zero = 0.0;
  for (std::size_t i = 0; i < types.size(); ++i) {
    const auto [type, usual] = types[i];
    const std::string name = std::to_string(i);
    make_attribute(file.get(), name.c_str(), type, &zero);
    double value = 1.0;
    const std::string told = told_by([&] { read_attribute(file.get(), name, std::span(&value, 1)); });
    EXPECT_EQ(told == "nothing", usual) << i << ": " << told;
    EXPECT_EQ(value, usual ? 0.0 : 1.0);
  }
}

TEST(Hdf5, FiniteAttributesAreFinite) {
  const Hdf5Handle file = file_in_memory();
  for (const double value : {0.25, -1e300, HUGE_VAL, -HUGE_VAL, std::nan("")}) {
    const std::string name = "a" + std::to_string(value);
    write_attribute(file.get(), name, value);
    const std::string told = told_by([&] { EXPECT_EQ(finite_attribute(file.get(), name), value); });
    EXPECT_EQ(told == "nothing", std::isfinite(value)) << told;
    EXPECT_NE(told.find("is not a finite number") != std::string::npos, std::isfinite(value)) << told;
  }
}

TEST(Hdf5, TellsTheSystemsWordsInOneLine) {
  EXPECT_EQ(told_by([] { open_hdf5("no/such/folder/file.h5", Hdf5Mode::create); }),
            "cannot create 'no/such/folder/file.h5': No such file or directory");
  EXPECT_EQ(told_by([] { open_hdf5("/dev/full", Hdf5Mode::create, /*user_block=*/512).close("write the file"); }),
            "cannot create '/dev/full': No space left on device");
}

}  // namespace
}  // namespace pliant::test_hdf5
