#include "base/error.hpp"
#include "base/file.hpp"
#include "io/history_writer.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "sample.hpp"

#include <cmath>
#include <csignal>
#include <fstream>
#include <limits>
#include <sstream>
#include <sys/resource.h>

#include <gtest/gtest.h>

namespace pliant::test_history_writer {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

TEST(HistoryWriter, RowsAreInTheFileAtOnceAndReadBackExactly) {
  const auto file = empty_directory(comm, "history") / "history.csv";
  HistoryWriter history(comm, file, {"step", "time", "tip, left_x"});
  const double third = 1.0 / 3.0, tiny = std::numeric_limits<double>::denorm_min();
  history.append(std::vector<double>{0, 0, -third});
  on_root(comm, [&] { EXPECT_EQ(read_text(file), "step,time,\"tip, left_x\"\n0,0,-0.3333333333333333\n"); });
  history.append(std::vector<double>{1000000, 0.1, tiny});
  on_root(comm, [&] {
    std::istringstream last(read_text(file).substr(read_text(file).find("1000000")));
    EXPECT_EQ(last.str(), "1000000,0.1,5e-324\n");
  });
}

TEST(HistoryWriter, EveryDoubleReadsBackAsItself) {
  double x = 1e-300;
  for (int i = 0; i < 2000; ++i, x *= -2.0389) {
    const std::string text = csv_row(std::vector<double>{x, x});
    EXPECT_EQ(std::stod(text), x);
    EXPECT_EQ(std::stod(text.substr(text.find(',') + 1)), x);
  }
  EXPECT_EQ(csv_row(std::vector<double>{std::nan(""), -INFINITY}), "nan,-inf");
}

TEST(HistoryWriter, ContinuesAfterTheGivenStep) {
  const auto file = empty_directory(comm, "continued") / "history.csv";
  const std::vector<std::string> columns{"step", "time"};
  {
    HistoryWriter history(comm, file, columns);
    for (int i = 0; i < 5; ++i) history.append(std::vector<double>{1.0 * i, 0.1 * i});
  }
  on_root(comm, [&] { std::ofstream(file, std::ios::app) << "5,0."; });  // cut off
  {
    HistoryWriter history(comm, file, columns, 2);
    history.append(std::vector<double>{3, 0.25});
  }
  on_root(comm, [&] { EXPECT_EQ(read_text(file), "step,time\n0,0\n1,0.1\n2,0.2\n3,0.25\n"); });
  EXPECT_THROW(HistoryWriter(comm, file, {"step", "dt"}, 2), FileError);
}

TEST(HistoryWriter, FailureIsFileErrorOnEveryRank) {
  const auto directory = empty_directory(comm, "history_fails");
  EXPECT_THROW(HistoryWriter(comm, directory / "missing" / "history.csv", {"step"}), FileError);
  if (std::filesystem::exists("/dev/full")) {
    try {
      const HistoryWriter refused(comm, "/dev/full", {"step"});
      FAIL() << "no exception";
    } catch (const FileError& e) {
      EXPECT_STREQ(e.what(), "cannot write '/dev/full': No space left on device");
    }
  }
}

TEST(HistoryWriter, AFileThatIsTakenAwayIsFileErrorOnEveryRank) {
  const auto directory = empty_directory(comm, "history_taken");
  const auto file = directory / "history.csv";
  HistoryWriter history(comm, file, {"step"});
  history.append(std::vector<double>{0});
  on_root(comm, [&] { std::filesystem::rename(file, directory / "taken.csv"); });
  EXPECT_THROW(history.append(std::vector<double>{1}), FileError);
  on_root(comm, [&] { std::ofstream(file) << "of somebody else"; });
  EXPECT_THROW(history.append(std::vector<double>{1}), FileError);
  on_root(comm, [&] {
    EXPECT_EQ(read_text(file), "of somebody else");
    EXPECT_EQ(read_text(directory / "taken.csv"), "step\n0\n");
  });
}

// A limit of the size of files stands for the end of the disk: the system writes what fits, then refuses.
TEST(HistoryWriter, ARowThatDoesNotFitIsNotThereAtAll) {
  const auto file = empty_directory(comm, "history_cut") / "history.csv";
  HistoryWriter history(comm, file, {"step", "time"});
  history.append(std::vector<double>{0, 0});
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit now = before;
  now.rlim_cur = std::string("step,time\n0,0\n1,0").size();
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &now), 0);
  EXPECT_THROW(history.append(std::vector<double>{1, 0.123456789}), FileError);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, handler);
  on_root(comm, [&] { EXPECT_EQ(read_text(file), "step,time\n0,0\n"); });
  history.append(std::vector<double>{1, 0.5});  // there is room again
  on_root(comm, [&] { EXPECT_EQ(read_text(file), "step,time\n0,0\n1,0.5\n"); });
}

TEST(WriteTextAtomically, ReplacesAndLeavesNoPartBehind) {
  const auto directory = empty_directory(comm, "text");
  on_root(comm, [&] {
    write_text_atomically(directory / "run.yaml", "first");
    write_text_atomically(directory / "run.yaml", "second");
    EXPECT_EQ(read_text(directory / "run.yaml"), "second");
    EXPECT_THROW(write_text_atomically(directory / "missing" / "run.yaml", "text"), FileError);
    EXPECT_THROW(write_text_atomically(directory, "text"), FileError);
    EXPECT_FALSE(std::filesystem::exists(directory / "run.yaml.part"));
  });
}

TEST(File, WritesAnywhereAndReserves) {
  const auto path = empty_directory(comm, "file") / "bytes";
  on_root(comm, [&] {
    File file(path, FileMode::create);
    const std::vector<double> values{1, 2, 3};
    file.write_at(8, std::as_bytes(std::span(values)));
    EXPECT_EQ(file.size(), 32);
    file.reserve(32, 100);
    EXPECT_EQ(file.size(), 132);
    file.reserve(0, 100);
    EXPECT_EQ(file.size(), 132);
    file.resize(16);
    EXPECT_EQ(std::filesystem::file_size(path), 16u);
    EXPECT_THROW(File(path / "below", FileMode::create), FileError);
  });
}

}  // namespace
}  // namespace pliant::test_history_writer
