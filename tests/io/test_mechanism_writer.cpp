#include "io/mechanism_writer.hpp"
#include "io/result_info.hpp"
#include "io/result_reader.hpp"
#include "petsc/collective.hpp"
#include "petsc/session.hpp"
#include "places.hpp"
#include "sample.hpp"

#include <cstdlib>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace pliant::test_mechanism_writer {
namespace {

const MPI_Comm comm = MPI_COMM_WORLD;

/// What tests/io/check_mechanisms.py expects: a tendon with three points, a spring, a hinge and a ball.
OutputMechanisms sample_mechanisms() {
  OutputMechanisms sample;
  sample.names = {"flexor", "coil", "knuckle", "wrist"};
  sample.kinds = {"tendon", "spring", "hinge", "ball"};
  sample.points = {0, 0, 0, 1, 0, 0, 2, 0, 1, /**/ 0, 1, 0, 0, 2, 0, /**/ 5, 5, 5, 5, 4, 5, 5, 6, 5, /**/
                   7, 7, 7, 6, 7, 7, 8, 7, 7};
  sample.segments = {0, 1, 1, 2, /**/ 3, 4, /**/ 6, 7, /**/ 9, 10};
  sample.parts = {0, 0, 1, 2, 3};
  sample.joints = {5, 8};
  return sample;
}

/// Everything has moved by (0, 0, step/10); the axis of the hinge turns from y to -y over 40 steps.
MechanismState moved(const OutputMechanisms& mechanisms, std::int64_t step) {
  const auto s = static_cast<double>(step);
  MechanismState state{mechanisms.points, {s, 0.5 * s, -s, 0, 0}, {0, 1 - s / 20, 0, 0, 0, 0}};
  for (std::size_t i = 2; i < state.points.size(); i += 3) state.points[i] += 0.1 * s;
  return state;
}

/// 0 if the result has frames of the mechanisms at the steps 0, 10, ..., as described.
int check_mechanisms(const std::filesystem::path& directory, int num_frames) {
  const std::string command = fmt::format("/usr/bin/python3 '{}/tests/io/check_mechanisms.py' '{}' {}",
                                          source_root().string(), directory.string(), num_frames);
  return std::system(command.c_str());
}

TEST(MechanismWriter, FramesAreReadAsTheyWereWrittenAndContinued) {
  const auto directory = empty_directory(comm, "mechanisms");
  const OutputMesh mesh = sample_mesh(comm, 4);
  const OutputMechanisms mechanisms = sample_mechanisms();
  const auto write = [&](ResultWriter& bodies, MechanismWriter& writer, std::int64_t step) {
    writer.write_frame(0.01 * static_cast<double>(step), step, moved(mechanisms, step));
    write_sample_frame(bodies, mesh, 0.01 * static_cast<double>(step), step);
  };
  {
    ResultWriter bodies(comm, directory, "block", mesh);
    MechanismWriter writer(comm, bodies, "block", mechanisms, -1);
    for (const std::int64_t step : {0, 10, 20, 30}) write(bodies, writer, step);
    writer.sync();
  }
  on_root(comm, [&] { EXPECT_EQ(check_mechanisms(directory, 4), 0); });
  // From step 15: what was written at 20 and 30 gives way.
  ResultWriter bodies(comm, directory, "block", mesh, 15);
  MechanismWriter writer(comm, bodies, "block", mechanisms, 15);
  on_root(comm, [&] { EXPECT_EQ(check_mechanisms(directory, 2), 0); });
  for (const std::int64_t step : {20, 30, 40}) write(bodies, writer, step);
  on_root(comm, [&] {
    EXPECT_EQ(check_mechanisms(directory, 5), 0);
    EXPECT_NE(describe_result(directory / "result.h5").find("mechanisms: flexor, coil, knuckle, wrist\n"),
              std::string::npos);
    const ResultReader reader(directory / "result.h5");
    const ResultFrame& last = reader.frames().back();
    const auto read = reader.mechanisms(last.mesh);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->names, mechanisms.names);
    EXPECT_EQ(read->kinds, mechanisms.kinds);
    EXPECT_EQ(read->points, mechanisms.points);
    EXPECT_EQ(read->segments, mechanisms.segments);
    EXPECT_EQ(read->parts, mechanisms.parts);
    EXPECT_EQ(read->joints, mechanisms.joints);
    const MechanismState state = reader.mechanism_state(last, *read), written = moved(mechanisms, 40);
    EXPECT_EQ(state.points, written.points);
    EXPECT_EQ(state.tensions, written.tensions);
    EXPECT_EQ(state.axes, written.axes);
  });
}

TEST(MechanismWriter, WithoutJoints) {
  const auto directory = empty_directory(comm, "lines");
  const OutputMesh mesh = sample_mesh(comm, 4);
  const OutputMechanisms one{{"coil"}, {"spring"}, {0, 1, 0, 0, 2, 0}, {0, 1}, {0}, {}};
  ResultWriter bodies(comm, directory, "block", mesh);
  MechanismWriter writer(comm, bodies, "block", one, -1);
  writer.write_frame(0.0, 0, {one.points, {3.0}, {}});
  write_sample_frame(bodies, mesh, 0.0, 0);
  on_root(comm, [&] {
    const ResultReader reader(directory / "result.h5");
    const auto read = reader.mechanisms("/mesh");
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->joints.empty());
    EXPECT_EQ(reader.mechanism_state(reader.frames().front(), *read).tensions, std::vector<double>{3.0});
  });
  const ResultWriter without(comm, directory, "block", mesh);
  on_root(comm, [&] { EXPECT_FALSE(std::filesystem::exists(without.companion_file("mechanisms"))); });
}

}  // namespace
}  // namespace pliant::test_mechanism_writer
