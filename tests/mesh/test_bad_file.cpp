// Bad meshes by the dozen (bad_meshes.py): each is one mistake of the user's, told alike on every rank.
#include "mesh/mesh.hpp"
#include "mesh/scratch.hpp"
#include "places.hpp"

#include <cstdlib>
#include <regex>

#include <gtest/gtest.h>

namespace pliant::test_bad_file {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

/// What read_mesh says to the file, at one place; empty if it takes it.
std::string complaint_about(const std::string& file) {
  MeshSource source;
  source.file = file;
  source.where = {"in.yaml", 3, 9};
  try {
    (void)read_mesh(comm, source);
    return "";
  } catch (const InputError& e) {
    EXPECT_EQ(e.diagnostics().size(), 1u) << e.what();
    EXPECT_EQ(to_string(e.diagnostics().at(0).where), "in.yaml:3:9");
    return e.diagnostics().at(0).message;
  }
}

TEST(BadMeshFiles, AreRefusedOnEveryRankWithOneReason) {
  const test::Scratch scratch(comm);
  const std::string directory = scratch.path("");
  on_root(comm, [&] {
    const std::string writer =
        "/usr/bin/python3 -B " + (source_root() / "tests/mesh/bad_meshes.py").string() + " " + directory;
    ASSERT_EQ(std::system(writer.c_str()), 0);
  });
  std::ifstream cases(directory + "cases.txt");
  int num_cases = 0;
  for (std::string file, pattern; std::getline(cases, file, '\t') && std::getline(cases, pattern); ++num_cases) {
    SCOPED_TRACE(file);
    const std::string message = complaint_about(directory + file);
    EXPECT_TRUE(std::regex_search(message, std::regex(pattern))) << message << "\nis not of the kind: " << pattern;
    EXPECT_EQ(message.find("mesh file '" + directory + file + "': "), 0u) << message;
    EXPECT_LT(message.size(), 700u) << message;
  }
  EXPECT_GE(num_cases, 140);
}

}  // namespace
}  // namespace pliant::test_bad_file
