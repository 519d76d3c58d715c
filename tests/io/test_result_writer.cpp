#include "base/error.hpp"
#include "io/result_writer.hpp"
#include "petsc/collective.hpp"
#include "petsc/hdf5.hpp"
#include "petsc/session.hpp"
#include "places.hpp"
#include "sample.hpp"

#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <regex>
#include <sstream>
#include <sys/mount.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_result_writer {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

std::vector<double> read_dataset(const std::filesystem::path& file, const std::string& place) {
  const Hdf5Handle h5 = open_hdf5(file, Hdf5Mode::read);
  const Hdf5Handle dataset(H5Dopen2(h5.get(), place.c_str(), H5P_DEFAULT), H5Dclose, "open " + place);
  const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose, "open " + place);
  std::vector<double> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  check_hdf5(H5Dread(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read " + place);
  return values;
}

double read_attribute(const std::filesystem::path& file, const std::string& place, const std::string& name) {
  const Hdf5Handle h5 = open_hdf5(file, Hdf5Mode::read);
  const Hdf5Handle attribute(H5Aopen_by_name(h5.get(), place.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                             "open " + name);
  double value = 0;
  check_hdf5(H5Aread(attribute.get(), H5T_NATIVE_DOUBLE, &value), "read " + name);
  return value;
}

std::string read_text(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

/// The places in result.h5 that an XDMF text refers to.
std::vector<std::string> places_in(const std::string& xdmf) {
  std::vector<std::string> places;
  const std::regex place("result\\.h5:([^<]*)<");
  for (std::sregex_iterator at(xdmf.begin(), xdmf.end(), place), end; at != end; ++at) places.push_back((*at)[1]);
  return places;
}

/// 0 if tests/io/check_xdmf.py finds the result to be what sample.hpp describes. On rank 0.
int check_xdmf(const std::filesystem::path& directory, int nodes_per_cell, int num_frames) {
  const std::string command =
      fmt::format("/usr/bin/python3 '{}/tests/io/check_xdmf.py' '{}' {} {}", source_root().string(),
                  (directory / "result.xdmf").string(), nodes_per_cell, num_frames);
  return std::system(command.c_str());
}

class ResultWriterOfOrder : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(NodesPerCell, ResultWriterOfOrder, testing::Values(4, 10));

TEST_P(ResultWriterOfOrder, ContentIsTheSameOnEveryRankCount) {
  const auto directory = empty_directory(comm, fmt::format("same_content_{}", GetParam()));
  for (const Split split : {Split::even, Split::none_on_last_rank}) {
    const OutputMesh mesh = sample_mesh(comm, GetParam(), split);
    ResultWriter writer(comm, directory / "parallel", "block", mesh);
    write_sample_frame(writer, mesh, 0.25, 7);
    on_root(comm, [&] {
      const OutputMesh whole = sample_mesh(MPI_COMM_SELF, GetParam());
      ResultWriter alone(MPI_COMM_SELF, directory / "alone", "block", whole);
      write_sample_frame(alone, whole, 0.25, 7);
      const auto file = directory / "parallel" / "result.h5", expected = directory / "alone" / "result.h5";
      EXPECT_EQ(read_dataset(file, "/frames/000000/displacement"), sample_displacement(whole, 0.25));
      for (const std::string place : {"/mesh/coordinates", "/mesh/cells", "/mesh/body", "/frames/000000/displacement",
                                      "/frames/000000/cauchy_stress", "/frames/000000/density"}) {
        EXPECT_EQ(read_dataset(file, place), read_dataset(expected, place)) << place;
      }
      EXPECT_EQ(read_attribute(file, "/frames/000000", "time"), 0.25);
      EXPECT_EQ(read_attribute(file, "/frames/000000", "step"), 7);
      EXPECT_EQ(read_text(directory / "parallel" / "result.xdmf"), read_text(directory / "alone" / "result.xdmf"));
    });
  }
}

TEST_P(ResultWriterOfOrder, XdmfReadsAsVtkGrids) {
  const auto directory = empty_directory(comm, fmt::format("xdmf_{}", GetParam()));
  const OutputMesh mesh = sample_mesh(comm, GetParam());
  ResultWriter writer(comm, directory, "block & <two> \"bodies\"", mesh);
  for (int i = 0; i < 3; ++i) write_sample_frame(writer, mesh, 0.1 * i, 10 * i);
  on_root(comm, [&] { EXPECT_EQ(check_xdmf(directory, GetParam(), 3), 0); });
}

TEST(ResultWriter, MidEdgeNodesLieOnTheEdgesInVtkOrder) {
  const auto directory = empty_directory(comm, "vtk_order");
  const OutputMesh mesh = sample_mesh(comm, 10);
  const ResultWriter writer(comm, directory, "block", mesh);
  on_root(comm, [&] {
    const auto x = read_dataset(directory / "result.h5", "/mesh/coordinates");
    const auto cells = read_dataset(directory / "result.h5", "/mesh/cells");
    ASSERT_EQ(cells.size() % 10, 0u);
    constexpr int ends[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
    for (std::size_t c = 0; c < cells.size(); c += 10) {
      const auto coordinate = [&](int node, std::size_t axis) {
        return x[3 * static_cast<std::size_t>(cells[c + static_cast<std::size_t>(node)]) + axis];
      };
      for (int e = 0; e < 6; ++e) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          EXPECT_DOUBLE_EQ(coordinate(4 + e, axis), (coordinate(ends[e][0], axis) + coordinate(ends[e][1], axis)) / 2);
        }
      }
    }
  });
}

TEST(ResultWriter, ReplacesAnEarlierResult) {
  const auto directory = empty_directory(comm, "replaces");
  const OutputMesh quadratic = sample_mesh(comm, 10), linear = sample_mesh(comm, 4);
  ResultWriter first(comm, directory, "first", quadratic);
  write_sample_frame(first, quadratic, 0, 0);
  write_sample_frame(first, quadratic, 1, 1);
  ResultWriter second(comm, directory, "second", linear);
  on_root(comm, [&] { EXPECT_TRUE(places_in(read_text(directory / "result.xdmf")).empty()); });
  write_sample_frame(second, linear, 0, 0);
  on_root(comm, [&] { EXPECT_EQ(check_xdmf(directory, 4, 1), 0); });
}

TEST(ResultWriter, ContinuesAfterTheGivenStep) {
  const auto directory = empty_directory(comm, "continues");
  const OutputMesh mesh = sample_mesh(comm, 10), other = sample_mesh(comm, 10, Split::none_on_last_rank);
  {
    ResultWriter first(comm, directory, "block", mesh, 0);
    for (int i = 0; i < 4; ++i) write_sample_frame(first, mesh, 0.1 * i, 10 * i);
  }
  {
    ResultWriter second(comm, directory, "block", other, 15);
    on_root(comm, [&] { EXPECT_EQ(check_xdmf(directory, 10, 2), 0); });
    for (int i = 2; i < 4; ++i) write_sample_frame(second, other, 0.1 * i, 10 * i);
  }
  ResultWriter third(comm, directory, "block", mesh, 30);
  write_sample_frame(third, mesh, 0.4, 40);
  on_root(comm, [&] {
    EXPECT_EQ(check_xdmf(directory, 10, 5), 0);
    const auto places = places_in(read_text(directory / "result.xdmf"));
    EXPECT_EQ(places.front(), "/mesh/cells");
    EXPECT_EQ(places.back(), "/mesh_2/rank");
    EXPECT_EQ(read_attribute(directory / "result.h5", "/frames/000004", "step"), 40);
  });
}

TEST(ResultWriter, FieldOfWrongSizeIsToldOnEveryRankAndTheNextFrameIsWritten) {
  const auto directory = empty_directory(comm, "wrong_size");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter writer(comm, directory, "block", mesh);
  const std::vector<double> values(mesh.bodies.size() + (rank(comm) == num_ranks(comm) - 1 ? 1 : 0), 1.0);
  const std::vector<OutputField> fields{{"density", "kg/m^3", FieldLocation::cell, 1, values}};
  EXPECT_ANY_THROW(writer.write_frame(0, 0, fields));
  write_sample_frame(writer, mesh, 0, 0);
  on_root(comm, [&] { EXPECT_EQ(check_xdmf(directory, 4, 1), 0); });
}

// A directory cannot be made below a file; this holds for root too, whom permissions do not stop.
TEST(ResultWriter, DirectoryThatCannotBeMadeIsFileErrorOnEveryRank) {
  const auto directory = empty_directory(comm, "no_directory");
  on_root(comm, [&] { std::ofstream(directory / "file") << "text"; });
  const OutputMesh mesh = sample_mesh(comm, 4);
  EXPECT_THROW(ResultWriter(comm, directory / "file", "block", mesh), FileError);
  EXPECT_THROW(ResultWriter(comm, directory / "file" / "below", "block", mesh), FileError);
}

TEST(ResultWriter, ReadOnlyDirectoryIsFileErrorOnEveryRank) {
  const auto directory = empty_directory(comm, "read_only");
  on_root(comm, [&] {
    using std::filesystem::perms;
    std::filesystem::permissions(directory, perms::owner_read | perms::owner_exec | perms::others_read);
  });
  // Root may write anywhere: act as "nobody" meanwhile.
  const bool as_root = ::geteuid() == 0;
  ASSERT_EQ(as_root ? ::seteuid(65534) : 0, 0);
  EXPECT_THROW(ResultWriter(comm, directory, "block", sample_mesh(comm, 4)), FileError);
  ASSERT_EQ(as_root ? ::seteuid(0) : 0, 0);
  on_root(comm, [&] { std::filesystem::permissions(directory, std::filesystem::perms::owner_all); });
}

TEST(ResultWriter, DirectoryThatVanishesIsFileErrorOnEveryRank) {
  const auto directory = empty_directory(comm, "vanishes");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter writer(comm, directory / "out", "block", mesh);
  write_sample_frame(writer, mesh, 0, 0);
  on_root(comm, [&] { std::filesystem::remove_all(directory / "out"); });
  EXPECT_THROW(write_sample_frame(writer, mesh, 1, 1), FileError);
  EXPECT_THROW(write_sample_frame(writer, mesh, 2, 2), FileError);
}

// Needs a file system that is small: one of 1 MiB is mounted where the test may (as root).
TEST(ResultWriter, FullDiskIsFileErrorOnEveryRankAndLeavesTheEarlierFrames) {
  const auto directory = empty_directory(comm, "full_disk");
  int mounted = 0;
  on_root(comm, [&] { mounted = ::mount("tmpfs", directory.c_str(), "tmpfs", 0, "size=1m") == 0 ? 1 : 0; });
  MPI_Bcast(&mounted, 1, MPI_INT, 0, comm);
  if (mounted == 0) GTEST_SKIP() << "may not mount a small file system";
  const OutputMesh mesh = sample_mesh(comm, 10);
  ResultWriter writer(comm, directory / "out", "block", mesh);
  bool full = false;
  int num_frames = 0;
  for (int i = 0; i < 1000 && !full; ++i) {
    try {
      write_sample_frame(writer, mesh, 0.1 * i, 10 * i);
      ++num_frames;
    } catch (const FileError& e) {
      full = true;
      EXPECT_NE(std::string(e.what()).find("No space left on device"), std::string::npos) << e.what();
    }
  }
  EXPECT_TRUE(full);
  EXPECT_GT(num_frames, 2);
  EXPECT_THROW(write_sample_frame(writer, mesh, 1e3, 1000), FileError);
  on_root(comm, [&] {
    EXPECT_EQ(check_xdmf(directory / "out", 10, num_frames), 0);
    EXPECT_EQ(::umount(directory.c_str()), 0);
  });
}

TEST(ResultWriter, ReaderHoldingTheFileOpenDoesNotDisturb) {
  const auto directory = empty_directory(comm, "reader");
  const OutputMesh mesh = sample_mesh(comm, 4);
  ResultWriter writer(comm, directory, "block", mesh);
  write_sample_frame(writer, mesh, 0, 0);
  pid_t reader = 0;
  on_root(comm, [&] {
    reader = ::fork();
    if (reader == 0) {
      const std::string script = "import h5py, time; f = h5py.File('" + (directory / "result.h5").string() +
                                 "', 'r'); open('" + (directory / "opened").string() + "', 'w'); time.sleep(60)";
      ::execl("/usr/bin/python3", "python3", "-c", script.c_str(), nullptr);
      ::_exit(1);
    }
    for (int i = 0; i < 600 && !std::filesystem::exists(directory / "opened"); ++i) ::usleep(50'000);
    EXPECT_TRUE(std::filesystem::exists(directory / "opened"));
  });
  EXPECT_NO_THROW(write_sample_frame(writer, mesh, 0.1, 10));
  on_root(comm, [&] {
    ::kill(reader, SIGKILL);
    ::waitpid(reader, nullptr, 0);
    EXPECT_EQ(check_xdmf(directory, 4, 2), 0);
  });
}

// HDF5 opens no file whose size it was told before the file grew.
TEST(ResultWriter, ReaderOfAnOlderSizeCanReadTheNextFrame) {
  const auto directory = empty_directory(comm, "older_size");
  const OutputMesh mesh = sample_mesh(comm, 10);
  ResultWriter writer(comm, directory, "block", mesh);
  const auto end_of_content = [&] {
    const Hdf5Handle file = open_hdf5(directory / "result.h5", Hdf5Mode::read);
    haddr_t end = 0;
    check_hdf5(H5Fget_eoa(file.get(), &end), "read");
    return end;
  };
  for (int i = 0; i < 5; ++i) {
    const auto older_size = std::filesystem::file_size(directory / "result.h5");
    MPI_Barrier(comm);
    const auto older_end = end_of_content();
    MPI_Barrier(comm);
    write_sample_frame(writer, mesh, 0.1 * i, i);
    EXPECT_GT(end_of_content(), older_end);
    EXPECT_LE(end_of_content(), older_size);
    MPI_Barrier(comm);
  }
  writer.sync();
  EXPECT_EQ(std::filesystem::file_size(directory / "result.h5"), end_of_content());
  on_root(comm, [&] { EXPECT_EQ(check_xdmf(directory, 10, 5), 0); });
}

/// What changes files, of the system calls that a frame makes.
bool changes_files(std::uint64_t call) {
  return call == SYS_write || call == SYS_pwrite64 || call == SYS_ftruncate || call == SYS_fallocate ||
         call == SYS_rename || call == SYS_unlink;
}

/// Runs `work` in a child of this process and kills it before the change of files number `count` that it makes after it
/// has stopped itself. False if it makes fewer.
bool killed_before_change(int count, const std::function<void()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    work();
    std::quick_exit(0);  // a build for coverage writes its counts at _exit(), which would be changes of files, too
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ::ptrace(PTRACE_SETOPTIONS, child, nullptr, PTRACE_O_TRACESYSGOOD);
  for (; WIFSTOPPED(status); ::waitpid(child, &status, 0)) {
    __ptrace_syscall_info info{};
    ::ptrace(PTRACE_GET_SYSCALL_INFO, child, sizeof(info), &info);
    const bool is_change = info.op == PTRACE_SYSCALL_INFO_ENTRY && changes_files(info.entry.nr);
    if (is_change && count-- == 0) ::kill(child, SIGKILL);
    ::ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
  }
  return WIFSIGNALED(status);
}

// A run that is killed before any of the changes of files that a frame makes goes on with all frames that are listed.
TEST(ResultWriter, KilledAtAnyMomentCanGoOnWithEveryListedFrame) {
  if (num_ranks(comm) > 1) GTEST_SKIP() << "a forked child cannot use MPI over several ranks";
  const auto directory = empty_directory(comm, "killed");
  const OutputMesh mesh = sample_mesh(MPI_COMM_SELF, 10);
  int num_changes = 0;
  const auto write_three_frames = [&] {
    ResultWriter writer(MPI_COMM_SELF, directory, "block", mesh);
    for (int i = 0; i < 2; ++i) write_sample_frame(writer, mesh, 0.1 * i, 10 * i);
    ::raise(SIGSTOP);
    write_sample_frame(writer, mesh, 0.2, 20);
  };
  for (; killed_before_change(num_changes, write_three_frames); ++num_changes) {
    const auto listed = places_in(read_text(directory / "result.xdmf"));
    for (const auto& place : listed) {
      ASSERT_NO_THROW(EXPECT_FALSE(read_dataset(directory / "result.h5", place).empty())) << place << num_changes;
    }
    ASSERT_NO_THROW({
      ResultWriter writer(MPI_COMM_SELF, directory, "block", mesh, 10);
      write_sample_frame(writer, mesh, 0.2, 20);
      writer.sync();
    }) << num_changes;
    EXPECT_EQ(check_xdmf(directory, 10, 3), 0) << num_changes;
  }
  EXPECT_GT(num_changes, 5);
}

}  // namespace
}  // namespace pliant::test_result_writer
