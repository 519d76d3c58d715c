// Scripts that would do more than build a geometry: nobody runs a program or writes a file by looking at a mesh.
#include "base/child_process.hpp"
#include "mesh/mesh.hpp"
#include "mesh/scratch.hpp"
#include "mesh/script_commands.hpp"
#include "mesh/serial_mesh.hpp"

#include <gtest/gtest.h>

namespace pliant::test_script_commands {
namespace {

using test::Scratch;

const MPI_Comm comm = MPI_COMM_WORLD;
const std::string box = "SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\n";

/// What is said to the file; empty if it is taken.
std::string complaint(const MeshSource& source) {
  try {
    (void)read_mesh(comm, source);
    return "";
  } catch (const InputError& e) {
    return e.what();
  }
}

MeshSource source_of(const std::string& file) {
  MeshSource source;
  source.file = file;
  source.size = 1.0;
  return source;
}

struct Script {
  const char* name;
  std::string content;
  std::string complaint;  ///< a part of it
};

std::ostream& operator<<(std::ostream& out, const Script& script) {
  return out << script.name;
}

std::vector<Script> with_commands() {
  const std::string touch = "\"touch made\";\n";
  std::string long_text(1100, 'x');
  return {
      {"SystemCall", box + "  SystemCall " + touch, "line 3, column 3: 'SystemCall' runs a program"},
      {"System", box + "System " + touch, "line 3, column 1: 'System' runs a program"},
      {"InTheBackground", box + "NonBlockingSystemCall " + touch, "'NonBlockingSystemCall' runs a program"},
      {"Onelab", box + "OnelabRun(\"a\", \"touch made\");\n", "'OnelabRun' runs a program"},
      {"OfAField", box + "Field[1] = ExternalProcess;\nField[1].CommandLine = \"touch made\";\nBackground Field = 1;\n",
       "line 3, column 12: 'ExternalProcess' runs a program"},
      {"MadeOfAText", box + "S2N[\"SystemCall\"] " + touch, "'S2N' can turn a text into a command"},
      {"Printf", box + "Printf(\"a > b\") > \"made\";\n", "line 3, column 1: 'Printf ... >' writes a file"},
      {"PrintfBehind", box + "Printf(Sprintf(\"%g\", 1)) >> \"made\";\n", "'Printf ... >' writes a file"},
      {"Save", box + "Mesh 3; Save \"made\";\n", "line 3, column 9: 'Save' writes a file"},
      {"Print", box + "Print \"made\";\n", "'Print' writes a file"},
      {"Directory", box + "CreateDir \"made\";\n", "'CreateDir' writes a file"},
      {"Plugin", box + "Plugin(NewView).Run;\n", "'Plugin' can write files"},
      {"ComputedName", box + "Merge StrCat(\"a\", \".geo\");\n", "'Merge' loads a file whose name is not a plain"},
      {"ZeroByte", box + "// " + std::string(1, '\0') + " SystemCall " + touch, "not a text"},
      {"LongText", box + "a = \"" + long_text + "\";\n", "more than 1000 bytes"},
      {"EndInAComment", box + "If (0)\nE/*\nEndIf\nSystemCall \"touch made\"; // */\n",
       "line 6, column 1: 'SystemCall'"},
      {"EndInAText", box + "If (0)\n a = \"EndIf\"; b = \" SystemCall 'touch made' ;\";\nEndIf\n", "'SystemCall' runs"},
      {"BehindTexts", box + "a = \"//\"; b = '/*'; SystemCall " + touch, "line 3, column 21: 'SystemCall'"},
      {"TwiceOnALine", box + "/* */ System /**/ " + touch, "line 3, column 7: 'System'"},
  };
}

class ScriptWithCommands : public ::testing::TestWithParam<Script> {};

TEST_P(ScriptWithCommands, IsRefusedAtTheStatementAndDoesNothing) {
  const Scratch scratch(comm);
  const auto cwd = std::filesystem::current_path();
  std::filesystem::current_path(std::filesystem::path(scratch.path("a")).parent_path());
  const std::string said = complaint(source_of(scratch.text("a.geo", GetParam().content)));
  EXPECT_NE(said.find(GetParam().complaint), std::string::npos) << said;
  EXPECT_NE(said.find("allow_commands: true"), std::string::npos) << said;
  EXPECT_FALSE(std::filesystem::exists("made"));
  MPI_Barrier(comm);
  std::filesystem::current_path(cwd);
}

INSTANTIATE_TEST_SUITE_P(All, ScriptWithCommands, ::testing::ValuesIn(with_commands()),
                         [](const auto& script) { return std::string(script.param.name); });

class ScriptWithoutCommands : public ::testing::TestWithParam<Script> {};

TEST_P(ScriptWithoutCommands, IsTaken) {
  const Scratch scratch(comm);
  const std::string file = scratch.text("a.geo", GetParam().content);
  EXPECT_NO_THROW(require_no_commands(file)) << GetParam().content;
}

INSTANTIATE_TEST_SUITE_P(All, ScriptWithoutCommands,
                         ::testing::ValuesIn(std::vector<Script>{
                             {"Box", box, ""},
                             {"InComments", box + "// Save or Print it; SystemCall\n/* Merge */\n", ""},
                             {"InTexts", box + "Printf(\"SystemCall > Save\");\n", ""},
                             {"Options", box + "Mesh.SaveAll = 1; Print.Background = 1; General.System = 1;\n", ""},
                             {"Comparison", box + "If (1 > 0)\n Printf(\"%g\", 2 > 1);\nEndIf\na = 3 > 2;\n", ""},
                             {"Names", box + "SaveSize = 1; my_System = 2; Printed = 3;\n", ""},
                             {"LoopWithComments", box + "For i In {1:2}\n // Save nothing\nEndFor // of the loop\n",
                              ""},
                         }),
                         [](const auto& script) { return std::string(script.param.name); });

TEST(ScriptCommands, AreFoundInFilesThatAreLoaded) {
  const Scratch scratch(comm);
  scratch.text("inner.geo", "x = 1;\n  SystemCall \"touch made\";\n");
  scratch.text("part.step", "SystemCall \"not a script\";\n");
  for (const char* loads : {"Include", "Merge"}) {
    const std::string outer = scratch.text("outer.geo", box + loads + " \"inner.geo\";\n");
    const std::string said = complaint(source_of(outer));
    EXPECT_NE(said.find("in 'inner.geo', which it loads, line 2, column 3: 'SystemCall'"), std::string::npos) << said;
  }
  EXPECT_NO_THROW(require_no_commands(scratch.text("cad.geo", "Merge \"part.step\";\nMerge \"cad.geo\";\n")));
  check_mpi(MPI_Barrier(comm));  // all have looked
  // gmsh loads the options that lie beside a file, whatever its format.
  scratch.text("part.step.opt", "SystemCall \"touch made\";\n");
  EXPECT_THROW(require_no_commands(scratch.path("part.step")), MeshDefect);
}

TEST(ScriptCommands, OfAnUnknownExtensionAreScripts) {
  const Scratch scratch(comm);
  EXPECT_THROW(require_no_commands(scratch.text("a.Step", "SystemCall \"x\";\n")), MeshDefect);
  EXPECT_THROW(require_no_commands(scratch.text("a.msh", "SystemCall \"x\";\n")), MeshDefect);
  EXPECT_NO_THROW(require_no_commands(scratch.text("b.msh", "$MeshFormat\nSystemCall\n")));
}

TEST(ScriptCommands, RunWhereTheyAreAllowed) {
  const Scratch scratch(comm);
  MeshSource source = source_of(scratch.text("a.geo", box + "SystemCall \"touch " + scratch.path("made") + "\";\n"));
  EXPECT_NE(complaint(source), "");
  EXPECT_FALSE(std::filesystem::exists(scratch.path("made")));
  source.commands = Commands::allowed;
  EXPECT_EQ(complaint(source), "");
  EXPECT_TRUE(std::filesystem::exists(scratch.path("made")));
}

TEST(ScriptCommands, ThatKillGmshAreToldOf) {
  const Scratch scratch(comm);
  MeshSource source = source_of(scratch.text("a.geo", box + "SystemCall \"kill -9 $PPID\";\n"));
  source.commands = Commands::allowed;
  EXPECT_NE(complaint(source).find("gmsh crashed while working on it (Killed)"), std::string::npos);
}

TEST(ScriptCommands, AChildThatReadsOnlyCannotRunOrWriteAnything) {
  if (rank(comm) != 0) return;
  const std::string made = (std::filesystem::temp_directory_path() / ("made_" + std::to_string(getpid()))).string();
  const auto work = [&] {
    const std::string call = "touch " + made;
    const bool has_run = std::system(call.c_str()) == 0;
    const bool has_written = std::ofstream(made).is_open();
    const bool has_read = std::ifstream("/proc/self/status").is_open();
    return std::string(has_run ? "ran " : "") + (has_written ? "wrote " : "") + (has_read ? "read" : "");
  };
  EXPECT_EQ(in_child(work, {ChildRights::reading}).answer, "read");
  EXPECT_FALSE(std::filesystem::exists(made));
  EXPECT_EQ(in_child(work).answer, "ran wrote read");
  std::filesystem::remove(made);
}

TEST(ScriptCommands, AScriptWithoutEndIsEnded) {
  const Scratch scratch(comm);
  MeshSource source = source_of(scratch.text("a.geo", box + "For i In {1:1000000000}\nx = i;\nEndFor\n"));
  source.time_limit = 0.5;
  const std::string said = complaint(source);
  EXPECT_NE(said.find("has not finished after 0.5 s"), std::string::npos) << said;
  EXPECT_NE(said.find("mesh.time_limit"), std::string::npos) << said;
}

}  // namespace
}  // namespace pliant::test_script_commands
