/// Files that a test writes on one rank and every rank reads.
#pragma once

#include "petsc/collective.hpp"
#include "petsc/session.hpp"

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <unistd.h>

namespace pliant::test {

/// A directory that lives as long as this object. Collective at both ends.
class Scratch {
 public:
  explicit Scratch(MPI_Comm comm) : comm_(comm) {
    directory_ = (std::filesystem::temp_directory_path() / ("pliant_test_" + std::to_string(getpid()))).string();
    directory_ = broadcast(comm, directory_);
    on_root(comm, [&] { std::filesystem::create_directories(directory_); });
  }
  ~Scratch() {
    MPI_Barrier(comm_);
    std::error_code ignored;
    if (rank(comm_) == 0) std::filesystem::remove_all(directory_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;

  std::string path(const std::string& name) const { return directory_ + "/" + name; }

  /// Runs `write(path)` on rank 0 and gives the path on every rank. Collective.
  std::string file(const std::string& name, const std::function<void(const std::string&)>& write) const {
    on_root(comm_, [&] { write(path(name)); });
    return path(name);
  }

  /// A file with this text. Collective.
  std::string text(const std::string& name, const std::string& content) const {
    return file(name, [&](const std::string& p) { std::ofstream(p, std::ios::binary) << content; });
  }

 private:
  MPI_Comm comm_;
  std::string directory_;
};

}  // namespace pliant::test
