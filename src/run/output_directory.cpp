#include "run/output_directory.hpp"

#include "petsc/collective.hpp"
#include "run/overlap_file.hpp"
#include "run/post_mortem.hpp"
#include "run/summary.hpp"

#include <chrono>

namespace pliant {
namespace {

/// How long to wait for a run that was just killed and may take a moment to end.
constexpr std::chrono::seconds patience{5};

}  // namespace

OutputDirectory::OutputDirectory(MPI_Comm comm, const Config& config) : comm_(comm), config_(config) {
  on_root(comm, [&] {
    make_directory(config.output.directory);
    lock_.emplace(config.output.directory, patience);
    remove_summary(config.output.directory);
  });
}

void OutputDirectory::start_anew(Checkpoints& checkpoints) {
  checkpoints.remove_all();
  remove_post_mortem(comm_, config_);
  remove_overlap_file(comm_, config_);
}

}  // namespace pliant
