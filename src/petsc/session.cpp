#include "petsc/session.hpp"

#include "base/error.hpp"
#include "petsc/blas_kernels.hpp"
#include "petsc/check.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <sched.h>
#include <string_view>

#include <hdf5.h>
#include <petscviewer.h>

namespace pliant {
namespace {

// Called by PETSc at each level of a failing call: pass the code up, print nothing.
PetscErrorCode pass_on(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType, const char*,
                       void*) {
  return code;
}

/// HDF5 would close itself in MPI_Finalize (if MPI was initialised before HDF5), or else at exit, and crashes there if
/// a damaged file could not be closed. Disabled: all files that Pliant opens it closes itself.
void keep_hdf5_from_closing_itself() {
  (void)H5dont_atexit();
  (void)H5open();
}

/// Makes waiting ranks yield the processor if, and only if, this machine has fewer processors than ranks. Otherwise
/// each poll for a message would give up the rest of a time slice (Linux since 6.6): next to another busy process, a
/// factorization then takes 4 to 20 times as long, on one rank too, because MUMPS polls there as well.
/// mpirun's own choice counts cores, not hardware threads, so that it yields too often.
void yield_only_if_oversubscribed() {
  const char* ranks = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");        // set by mpirun
  if (ranks == nullptr && std::getenv("PMIX_RANK") != nullptr) return;  // srun: unknown how many
  cpu_set_t processors;
  if (sched_getaffinity(0, sizeof processors, &processors) != 0) return;
  const bool is_oversubscribed = ranks != nullptr && std::atoi(ranks) > CPU_COUNT(&processors);
  if (is_oversubscribed && std::getenv("OMPI_MCA_orte_bound_at_launch") != nullptr) return;  // each has its own cores
  (void)setenv("OMPI_MCA_mpi_yield_when_idle", is_oversubscribed ? "1" : "0", 1);
}

/// A variable of the environment that has a value while this lives, unless it has one already.
class Default {
 public:
  Default(const char* name, const char* value) : name_(std::getenv(name) == nullptr ? name : nullptr) {
    if (name_ != nullptr) (void)setenv(name_, value, 1);
  }
  ~Default() {
    if (name_ != nullptr) (void)unsetenv(name_);
  }
  Default(const Default&) = delete;
  Default& operator=(const Default&) = delete;

 private:
  const char* name_;
};

/// Whether no launcher (mpirun, srun, another MPI's) started this process.
bool is_alone() {
  const auto is_set = [](const char* name) { return std::getenv(name) != nullptr; };
  return std::ranges::none_of(
      std::array{"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE", "SLURM_PROCID", "FLUX_TASK_RANK"},
      is_set);
}

/// Whether all ranks are on this machine, as far as mpirun says so.
bool is_on_one_machine() {
  const char* here = std::getenv("OMPI_COMM_WORLD_LOCAL_SIZE");
  const char* all = std::getenv("OMPI_COMM_WORLD_SIZE");
  return is_alone() || (here != nullptr && all != nullptr && std::atoi(here) == std::atoi(all));
}

/// Initialises PETSc, and MPI with it. Ranks of one machine do not look for networks, and a process alone starts no
/// daemon for processes that it might spawn: both took most of the time that a short run takes (0.25 of 0.35 s). Nor
/// does it make a directory for its session, which another process that ends might take away. What the user chose for
/// Open MPI stays, and processes that this one starts see nothing of it.
void initialise(int argc, char** argv) {
  std::optional<Default> daemon, session, protocol, transports;
  if (is_alone()) {
    daemon.emplace("OMPI_MCA_ess_singleton_isolated", "1");
    session.emplace("OMPI_MCA_orte_create_session_dirs", "0");
  }
  if (is_on_one_machine() && std::getenv("OMPI_MCA_btl") == nullptr) {
    protocol.emplace("OMPI_MCA_pml", "ob1");
    if (const char* chosen = std::getenv("OMPI_MCA_pml"); std::string_view(chosen) == "ob1") {
      transports.emplace("OMPI_MCA_btl", is_alone() ? "self" : "self,vader");
    }
  }
  check(PetscInitialize(&argc, &argv, nullptr, nullptr));
}

/// Sets one BLAS thread per rank, unless the user asks for more: ranks are the parallelism, and OpenBLAS would start a
/// thread per core in each. The function is looked up at run time because another BLAS may replace OpenBLAS.
void use_one_blas_thread() {
  if (std::getenv("OPENBLAS_NUM_THREADS") != nullptr || std::getenv("OMP_NUM_THREADS") != nullptr) return;
  using SetThreads = void (*)(int);
  const auto set_threads = reinterpret_cast<SetThreads>(symbol_of_blas("openblas_set_num_threads"));
  if (set_threads != nullptr) set_threads(1);
}

}  // namespace

Session::Session(const std::string& program, const std::vector<std::string>& petsc_options) {
  // PETSc's signal handlers would end a process that nohup started at SIGHUP.
  std::vector<std::string> texts{program, "-no_signal_handler", "1"};
  texts.insert(texts.end(), petsc_options.begin(), petsc_options.end());
  std::vector<char*> pointers;
  for (auto& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  int argc = static_cast<int>(texts.size());
  char** argv = pointers.data();
  keep_hdf5_from_closing_itself();
  PetscBool is_running = PETSC_FALSE;
  check(PetscInitialized(&is_running));
  owns_petsc_ = is_running == PETSC_FALSE;
  if (!owns_petsc_) {
    use_one_blas_thread();
    return;
  }
  yield_only_if_oversubscribed();
  check(PetscPushErrorHandler(pass_on, nullptr));  // first, or PETSc itself prints an error about an invalid option
  try {
    // PETSc keeps argv until PetscFinalize only for PetscGetArgs, which nobody here calls.
    initialise(argc, argv);
  } catch (const PetscFailure& failure) {
    throw InputError({"PETSc options", 0, 0}, failure.what());
  }
  use_one_blas_thread();
  check(PetscOptionsClearValue(nullptr, "-no_signal_handler"));  // petsc_options() keeps the user's
}

SilentPetsc::SilentPetsc() {
  (void)PetscPushErrorHandler(pass_on, nullptr);
}
SilentPetsc::~SilentPetsc() {
  (void)PetscPopErrorHandler();
}

Session::~Session() {
  if (!owns_petsc_) return;
  (void)PetscOptionsSetValue(nullptr, "-options_left", "0");
  (void)PetscPopErrorHandler();
  (void)PetscFinalize();
}

int rank(MPI_Comm comm) {
  int r = 0;
  check_mpi(MPI_Comm_rank(comm, &r));
  return r;
}

int num_ranks(MPI_Comm comm) {
  int n = 1;
  check_mpi(MPI_Comm_size(comm, &n));
  return n;
}

std::string petsc_options() {
  char* text = nullptr;
  check(PetscOptionsGetAll(nullptr, &text));
  std::string result = text;
  check(PetscFree(text));
  return result;
}

std::vector<std::string> unused_petsc_options() {
  PetscInt count = 0;
  char** names = nullptr;
  char** values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  std::vector<std::string> unused;
  for (PetscInt i = 0; i < count; ++i) {
    if (std::string(names[i]) != "options_left") unused.push_back(std::string("-") + names[i]);
  }
  check(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  return unused;
}

}  // namespace pliant
