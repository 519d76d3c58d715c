#include "base/error.hpp"
#include "io/checkpoint_file.hpp"
#include "petsc/array_view.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "sample.hpp"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

namespace pliant::test_checkpoint_file {
namespace {

namespace fs = std::filesystem;

const MPI_Comm comm = MPI_COMM_WORLD;

constexpr std::int64_t num_nodes = 29;

/// The nodes are dealt to the ranks like cards, so that rows and entries lie on different ranks.
std::vector<EntryKey> nodes_here() {
  std::vector<EntryKey> keys;
  for (std::int64_t n = rank(comm); n < num_nodes; n += num_ranks(comm)) keys.push_back({n, n});
  return keys;
}

ArchiveOrders orders() {
  return {{comm, nodes_here()}, {comm, std::vector<EntryKey>{}}, {comm, nodes_here()}};
}

/// What an object with a state would be.
struct Thing {
  int count = 0;
  double x = 0.0;
  bool is_set = false;
  std::array<double, 3> numbers{};
  Handle<Vec> q, p;

  Thing() {
    const auto num_here = static_cast<PetscInt>(nodes_here().size());
    check(VecCreateMPI(comm, 3 * num_here, PETSC_DECIDE, q.out()));
    check(VecCreateMPI(comm, num_here, PETSC_DECIDE, p.out()));
  }
  void set() {
    count = 12;
    x = 1.0 / 3.0;
    is_set = true;
    numbers = {1e-300, -0.0, 7.0};
    const ArrayView of_q(q.get()), of_p(p.get());
    const auto keys = nodes_here();
    for (std::size_t i = 0; i < keys.size(); ++i) {
      const auto n = static_cast<double>(keys[i].first);
      of_p.span()[i] = -n;
      for (std::size_t k = 0; k < 3; ++k) of_q.span()[3 * i + k] = n + 0.1 * static_cast<double>(k);
    }
  }
  void keep(Archive& archive) {
    archive.number("count", count);
    const Archive::Section section(archive, "part");
    archive.number("x", x);
    archive.number("is_set", is_set);
    archive.numbers("numbers", numbers);
    archive.vector("q", Entries::nodes, q.get());
    archive.vector("p", Entries::pressures, p.get());
  }
};

const CheckpointInfo info{12, 0.25, "a run", "mesh: {file: a.msh}\n", "0123", "pliant 0\n", "", 3};

class CheckpointFile : public ::testing::Test {
 protected:
  CheckpointFile() {
    Thing thing;
    thing.set();
    CheckpointWriter writer(comm, orders_);
    thing.keep(writer);
    writer.write(file_, info);
  }
  /// Collective: no rank reads while another one replaces them.
  std::string bytes() const {
    std::ostringstream text;
    on_root(comm, [&] { text << std::ifstream(file_, std::ios::binary).rdbuf(); });
    return broadcast(comm, text.str());
  }
  void replace(const std::string& bytes) const {
    on_root(comm, [&] { std::ofstream(file_, std::ios::binary) << bytes; });
  }

  ArchiveOrders orders_ = orders();
  fs::path directory_ = empty_directory(comm, "checkpoint");
  fs::path file_ = directory_ / "checkpoint-000012.h5";
};

TEST_F(CheckpointFile, GivesBackWhatWasKept) {
  const CheckpointInfo read = read_checkpoint_info(comm, file_);
  EXPECT_EQ(read.step, info.step);
  EXPECT_EQ(read.time, info.time);
  EXPECT_EQ(read.title, info.title);
  EXPECT_EQ(read.input, info.input);
  EXPECT_EQ(read.mesh, info.mesh);
  EXPECT_EQ(read.program, info.program);
  EXPECT_EQ(read.petsc_options, info.petsc_options);
  EXPECT_EQ(read.ranks, info.ranks);
  Thing wanted, thing;
  wanted.set();
  CheckpointReader reader(comm, file_, orders_);
  thing.keep(reader);
  EXPECT_EQ(thing.count, wanted.count);
  EXPECT_EQ(thing.x, wanted.x);
  EXPECT_EQ(thing.is_set, wanted.is_set);
  EXPECT_EQ(thing.numbers, wanted.numbers);
  for (const auto& [a, b] : {std::pair{thing.q.get(), wanted.q.get()}, {thing.p.get(), wanted.p.get()}}) {
    PetscBool same = PETSC_FALSE;
    check(VecEqual(a, b, &same));
    EXPECT_TRUE(same);
  }
}

TEST_F(CheckpointFile, LeavesNoPartBehind) {
  EXPECT_TRUE(fs::exists(file_));
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()), 1);
}

TEST_F(CheckpointFile, IsTheSameOnAnyNumberOfRanks) {
  // Rows are in the order of the nodes: the first of q is that of node 0.
  on_root(comm, [&] {
    const Hdf5Handle file = open_hdf5(file_, Hdf5Mode::read);
    const Hdf5Handle q(H5Dopen2(file.get(), "state/part.q", H5P_DEFAULT), H5Dclose, "open q");
    std::vector<double> values(3 * num_nodes);
    check_hdf5(H5Dread(q.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "read q");
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t node = i / 3;
      EXPECT_EQ(values[i], static_cast<double>(node) + 0.1 * static_cast<double>(i % 3));
    }
  });
}

TEST_F(CheckpointFile, AnyByteThatIsWrongIsFound) {
  const std::string whole = bytes();
  for (std::size_t i = 0; i < whole.size(); i += whole.size() / 101) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    replace(damaged);
    EXPECT_THROW(read_checkpoint_info(comm, file_), FileError) << "byte " << i;
  }
  for (std::size_t size = 0; size < whole.size(); size += whole.size() / 17) {
    replace(whole.substr(0, size));
    EXPECT_THROW(read_checkpoint_info(comm, file_), FileError) << "size " << size;
  }
  replace(whole + '\0');
  EXPECT_THROW(read_checkpoint_info(comm, file_), FileError);
  replace(whole);
  EXPECT_NO_THROW(read_checkpoint_info(comm, file_));
}

TEST_F(CheckpointFile, WhatIsNotInItIsAFileError) {
  CheckpointReader reader(comm, file_, orders_);
  double x = 0.0;
  std::array<double, 2> numbers{};
  Thing thing;
  EXPECT_THROW(reader.number("nothing", x), FileError);
  EXPECT_THROW(reader.numbers("part.numbers", numbers), FileError);
  EXPECT_THROW(reader.vector("nothing", Entries::nodes, thing.q.get()), FileError);
  EXPECT_THROW(reader.vector("part.p", Entries::nodes, thing.q.get()), FileError);
}

TEST_F(CheckpointFile, AFailureLeavesTheFileThereWas) {
  const std::string whole = bytes();
  on_root(comm, [&] { fs::create_directory(fs::path(file_) += ".part"); });
  const CheckpointWriter writer(comm, orders_);
  EXPECT_THROW(writer.write(file_, info), FileError);
  EXPECT_EQ(bytes(), whole);
  EXPECT_THROW(writer.write(directory_ / "missing" / "checkpoint-000001.h5", info), FileError);
}

}  // namespace
}  // namespace pliant::test_checkpoint_file
