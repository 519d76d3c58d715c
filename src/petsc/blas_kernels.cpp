#include "petsc/blas_kernels.hpp"

#include <cstdlib>
#include <dlfcn.h>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <unistd.h>

namespace pliant {
namespace {

constexpr const char* variable = "OPENBLAS_CORETYPE";

/// The newest kernels of which the processor has all instructions; nullptr: those for the oldest fit, or it is of
/// another architecture.
const char* fitting_kernels() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const auto has_avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                          __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl");
  if (has_avx512) return "SkylakeX";
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "Haswell";
#endif
  return nullptr;
}

/// Whether OpenBLAS could be made to read the variable once more.
bool choose_again() {
  using Call = void (*)();
  const auto quit = reinterpret_cast<Call>(symbol_of_blas("gotoblas_dynamic_quit"));
  const auto start = reinterpret_cast<Call>(symbol_of_blas("gotoblas_dynamic_init"));
  if (quit == nullptr || start == nullptr) return false;
  quit();
  start();
  return true;
}

}  // namespace

void* symbol_of_blas(const char* name) {
  if (void* const found = dlsym(RTLD_DEFAULT, name)) return found;
  // What a module of an interpreter links is not in the global scope.
  void* const blas = dlopen("libblas.so.3", RTLD_LAZY | RTLD_NOLOAD);
  return blas == nullptr ? nullptr : dlsym(blas, name);
}

const char* better_blas_kernels() {
  if (std::getenv(variable) != nullptr) return nullptr;
  using GetName = char* (*)();
  const auto name_of_kernels = reinterpret_cast<GetName>(symbol_of_blas("openblas_get_corename"));
  if (name_of_kernels == nullptr || std::string_view(name_of_kernels()) != "Prescott") return nullptr;
  return fitting_kernels();
}

void take_fitting_blas_kernels(char** argv) {
  const char* const kernels = better_blas_kernels();
  if (kernels == nullptr || setenv(variable, kernels, 0) != 0) return;
  if (choose_again()) return;
  std::error_code failed;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (!failed) (void)execv(program.c_str(), argv);
}

}  // namespace pliant
