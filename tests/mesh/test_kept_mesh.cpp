// A mesh that gmsh made once is not made again, unless something that it depends on has changed.
#include "mesh/gmsh_import.hpp"
#include "mesh/kept_mesh.hpp"
#include "mesh/scratch.hpp"
#include "mesh/serial_mesh.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

namespace pliant::test_kept_mesh {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

/// The directory of kept meshes, of this test alone.
class KeptMesh : public testing::Test {
 protected:
  KeptMesh() { setenv("XDG_CACHE_HOME", scratch_.path("cache").c_str(), 1); }
  ~KeptMesh() override { unsetenv("XDG_CACHE_HOME"); }

  MeshSource source(const std::string& script, double size = 1.0) const {
    MeshSource source;
    source.file = scratch_.text("body.geo", script);
    source.size = size;
    return source;
  }
  std::vector<fs::path> kept() const {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(scratch_.path("cache/pliant/meshes"), ignored)) {
      files.push_back(entry.path());
    }
    return files;
  }

  Scratch scratch_{MPI_COMM_SELF};
};

bool is_kept(const SerialMesh& mesh) {
  return !mesh.notices.empty() && mesh.notices.back().find("its mesh is that of an earlier run") == 0;
}

const std::string box =
    "SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhysical Volume(\"cube\") = {1};\n";

TEST_F(KeptMesh, IsTheOneThatGmshMade) {
  const SerialMesh made = import_mesh(source(box)), again = import_mesh(source(box));
  EXPECT_FALSE(is_kept(made));
  ASSERT_TRUE(is_kept(again));
  EXPECT_EQ(again.coordinates, made.coordinates);
  EXPECT_EQ(again.cells, made.cells);
  EXPECT_EQ(again.node_tags, made.node_tags);
  ASSERT_EQ(again.groups.size(), made.groups.size());
  EXPECT_EQ(again.groups[0].group.name, "cube");
  EXPECT_EQ(again.groups[0].members, made.groups[0].members);
  EXPECT_EQ(again.notices.size(), made.notices.size() + 1);
}

TEST_F(KeptMesh, IsMadeAnewForAnotherGeometryOrSize) {
  import_mesh(source(box));
  EXPECT_FALSE(is_kept(import_mesh(source(box + "// another\n"))));
  EXPECT_FALSE(is_kept(import_mesh(source(box, 0.5))));
  EXPECT_TRUE(is_kept(import_mesh(source(box, 0.5))));
  scratch_.text("part.geo", "Box(1) = {0, 0, 0, 1, 1, 1};\n");
  const std::string loading = "SetFactory(\"OpenCASCADE\");\nInclude \"part.geo\";\n";
  import_mesh(source(loading));
  EXPECT_TRUE(is_kept(import_mesh(source(loading))));
  scratch_.text("part.geo", "Box(1) = {0, 0, 0, 1, 1, 2};\n");
  EXPECT_FALSE(is_kept(import_mesh(source(loading))));
}

TEST_F(KeptMesh, IsNoneWhereAScriptAsksForMoreThanItsFiles) {
  const std::string asking = box + "If (StrCmp(GetEnv(\"PLIANT_NO_SUCH\"), \"\") != 0)\nEndIf\n";
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(is_kept(import_mesh(source(asking))));
  EXPECT_TRUE(kept().empty());
}

TEST_F(KeptMesh, IsMadeAnewWhereTheFileIsDamaged) {
  import_mesh(source(box));
  ASSERT_EQ(kept().size(), 1u);
  const fs::path file = kept()[0];
  const auto size = fs::file_size(file);
  constexpr std::uintmax_t of_magic = 0, of_size = 24;  // the sixth byte of the recipe's size
  for (const auto at : {size - 1, size / 2, of_magic, of_size}) {
    {
      std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
      stream.seekg(static_cast<std::streamoff>(at));
      const auto old = static_cast<char>(stream.get());
      stream.seekp(static_cast<std::streamoff>(at));
      stream.put(static_cast<char>(old ^ 1));
    }
    EXPECT_FALSE(is_kept(import_mesh(source(box)))) << at;
    EXPECT_TRUE(is_kept(import_mesh(source(box))));
  }
  fs::resize_file(file, size / 2);
  EXPECT_FALSE(is_kept(import_mesh(source(box))));
}

TEST_F(KeptMesh, IsNeededByNobody) {
  scratch_.text("cache", "a file in place of the directory");
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(is_kept(import_mesh(source(box))));
}

}  // namespace
}  // namespace pliant::test_kept_mesh
