// The corpora of the fuzzers, as they are and damaged at random: a short look at what tools/fuzz.sh does for long.
#include "fuzz/targets.hpp"
#include "places.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sys/resource.h>

#include <gtest/gtest.h>
#include <hdf5.h>

namespace pliant::fuzz::test_replay {
namespace {

namespace fs = std::filesystem;

/// Contents by name: the seeds, and what fuzzing found.
std::vector<std::pair<std::string, std::string>> corpus_of(const std::string& target) {
  std::vector<std::pair<std::string, std::string>> result;
  for (const auto& entry : fs::directory_iterator(source_root() / "tests/fuzz/corpus" / target)) {
    std::ifstream in(entry.path(), std::ios::binary);
    result.emplace_back(entry.path().filename().string(), std::string(std::istreambuf_iterator<char>(in), {}));
  }
  std::ranges::sort(result);
  return result;
}

/// A few bytes overwritten, left out or put elsewhere.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto place = [&] { return static_cast<std::size_t>(random() % (bytes.size() + 1)); };
  for (unsigned i = 0; i < 1 + random() % 3; ++i) {
    const std::size_t at = place(), length = std::min<std::size_t>(random() % 16, bytes.size() - at);
    switch (random() % 5) {
      case 0:
        bytes.erase(at, length);
        break;
      case 1:
        bytes.insert(at, bytes.substr(std::min(place(), bytes.size()), length));
        break;
      case 2:
        std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length, random() % 2 == 0 ? '\xFF' : '9');
        break;
      default:
        if (at < bytes.size()) bytes[at] = static_cast<char>(random());
    }
  }
  return bytes;
}

/// Files, and what is in them; HDF5 keeps a file open as long as anything in it is.
std::ptrdiff_t num_open_in_hdf5() {
  return H5Fget_obj_count(static_cast<hid_t>(H5F_OBJ_ALL), H5F_OBJ_ALL);
}

/// What this process has held at most [MB].
long peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss / 1024;
}

class Reader : public ::testing::TestWithParam<Target> {};

TEST_P(Reader, TakesOrRefusesItsCorpus) {
  const auto corpus = corpus_of(GetParam().name);
  ASSERT_GE(corpus.size(), 3u);
  for (const auto& [name, bytes] : corpus) {
    EXPECT_NO_THROW(GetParam().run(bytes)) << name;
    ASSERT_LT(peak_memory(), 1000) << name << " was believed about how much it holds";
  }
}

TEST_P(Reader, TakesOrRefusesWhatIsDamaged) {
  const auto corpus = corpus_of(GetParam().name);
  std::mt19937 random(1);
  for (int round = 0; round < GetParam().rounds; ++round) {
    const auto& [name, bytes] = corpus[random() % corpus.size()];
    EXPECT_NO_THROW(GetParam().run(damaged(bytes, random))) << name << " in round " << round;
    ASSERT_EQ(num_open_in_hdf5(), 0) << name << " in round " << round;
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, Reader,
    ::testing::Values(Target{"input", read_as_input}, Target{"fit", read_as_fit}, Target{"msh", read_as_msh},
                      Target{"abaqus", read_as_abaqus, /*rounds=*/200},
                      Target{"nastran", read_as_nastran, /*rounds=*/200},
                      Target{"medit", read_as_medit, /*rounds=*/200}, Target{"unv", read_as_unv, /*rounds=*/200},
                      Target{"vtk", read_as_vtk, /*rounds=*/200}, Target{"vtu", read_as_vtu, /*rounds=*/200},
                      Target{"med", read_as_med, /*rounds=*/40}, Target{"mesh_file", read_as_mesh_file, /*rounds=*/40},
                      Target{"surface", read_as_surface, /*rounds=*/10}, Target{"triangles", read_as_triangles},
                      Target{"result", read_as_result}, Target{"checkpoint", read_as_checkpoint}),
    [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace pliant::fuzz::test_replay
