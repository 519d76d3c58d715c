// Files under names that others may have taken.
#include "base/error.hpp"
#include "base/file.hpp"

#include <fstream>
#include <iterator>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

namespace pliant::test_file {
namespace {

namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  Files() : directory_(fs::temp_directory_path() / ("pliant_files_" + std::to_string(getpid()))) {
    fs::create_directories(directory_);
  }
  ~Files() override { fs::remove_all(directory_); }

  static std::string text_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  static void put(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

  fs::path directory_;
};

TEST_F(Files, ALinkInThePlaceOfAPartIsNotFollowed) {
  const fs::path victim = directory_ / "victim", target = directory_ / "result";
  put(victim, "mine");
  fs::create_symlink(victim, directory_ / "result.part");
  write_text_atomically(target, "new", Durability::process);
  EXPECT_EQ(text_of(victim), "mine");
  EXPECT_EQ(text_of(target), "new");
  EXPECT_FALSE(fs::is_symlink(target));
  EXPECT_FALSE(fs::exists(directory_ / "result.part"));
}

TEST_F(Files, AHardLinkInThePlaceOfAPartIsNotWritten) {
  const fs::path victim = directory_ / "victim";
  put(victim, "mine");
  fs::create_hard_link(victim, directory_ / "result.part");
  write_text_atomically(directory_ / "result", "new", Durability::process);
  EXPECT_EQ(text_of(victim), "mine");
}

TEST_F(Files, APartOfAnEarlierRunIsReplaced) {
  put(directory_ / "result.part", "what a run that was killed has left");
  write_text_atomically(directory_ / "result", "new", Durability::process);
  EXPECT_EQ(text_of(directory_ / "result"), "new");
}

TEST_F(Files, WhatCannotBeReplacedIsAFailure) {
  fs::create_directories(directory_ / "result.part" / "taken");
  EXPECT_THROW(write_text_atomically(directory_ / "result", "new", Durability::process), FileError);
  EXPECT_TRUE(fs::exists(directory_ / "result.part" / "taken"));
}

}  // namespace
}  // namespace pliant::test_file
