// Programs side by side: how they end, how many at a time, what stops them.
#include "mesh/scratch.hpp"
#include "study/processes.hpp"

#include <csignal>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include <gtest/gtest.h>

namespace pliant::test_processes {
namespace {

class Processes : public ::testing::Test {
 protected:
  Program shell(const std::string& script) {
    return {{"sh", "-c", script}, scratch_.path(std::to_string(++count_) + ".log")};
  }
  static std::string text(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::vector<Ended> run(const std::vector<Program>& programs, int at_once) {
    return run_all(programs, {"PATH=/usr/bin:/bin", "COLOUR=green"}, at_once,
                   [this](std::size_t index, const Ended&) { order_.push_back(index); });
  }
  test::Scratch scratch_{MPI_COMM_SELF};
  int count_ = 0;
  std::vector<std::size_t> order_;
};

TEST_F(Processes, TellHowTheyEndedAndWhatTheySaid) {
  const std::vector<Program> programs{shell("echo $COLOUR; echo trouble >&2; exit 3"),
                                      shell("exit 0"),
                                      shell("kill -9 $$"),
                                      {{"no-such-program"}, scratch_.path("none.log")}};
  const auto ended = run(programs, 2);
  EXPECT_EQ(ended[0].code, 3);
  EXPECT_EQ(text(programs[0].log), "green\ntrouble\n");
  EXPECT_EQ(ended[1].code, 0);
  EXPECT_EQ(ended[2].code, 128 + SIGKILL);
  EXPECT_EQ(ended[3].code, 127);
  EXPECT_EQ(order_.size(), 4u);
}

TEST_F(Processes, AreNotMoreAtATimeThanAsked) {
  // Each finds the mark of one that runs at the same time, if there is one.
  const std::string mark = scratch_.path("mark");
  const std::string alone = "mkdir " + mark + " || exit 1; sleep 0.05; rmdir " + mark;
  for (const auto& ended : run({shell(alone), shell(alone), shell(alone)}, 1)) EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(order_, (std::vector<std::size_t>{0, 1, 2}));
  // And two wait for each other, which only ends if they do run together.
  const std::string a = mark + "_a", b = mark + "_b";
  const auto meet = [](const std::string& mine, const std::string& other) {
    return "touch " + mine + "; while ! [ -e " + other + " ]; do sleep 0.01; done";
  };
  for (const auto& ended : run({shell(meet(a, b)), shell(meet(b, a))}, 2)) EXPECT_EQ(ended.code, 0);
}

TEST_F(Processes, AreStoppedByASignalAndNoFurtherOneIsStarted) {
  // The first one sends the signal to this process.
  const std::string parent = std::to_string(getpid());
  const auto ended = run({shell("kill -TERM " + parent + "; sleep 60"), shell("exit 0")}, 1);
  EXPECT_EQ(ended[0].code, 128 + SIGTERM);
  EXPECT_EQ(ended[1].code, 128 + SIGTERM);
  EXPECT_LT(ended[0].seconds, 30.0);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path("2.log")));
}

TEST_F(Processes, AtLeastOneProcessorIsUsable) {
  EXPECT_GE(usable_processors(), 1);
}

}  // namespace
}  // namespace pliant::test_processes
