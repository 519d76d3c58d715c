#include "petsc/check.hpp"

namespace pliant {
namespace {

std::string place(const std::source_location& where) {
  std::string file = where.file_name();
  const auto slash = file.rfind("src/");
  if (slash != std::string::npos) file.erase(0, slash);
  return file + ":" + std::to_string(where.line());
}

}  // namespace

void check(PetscErrorCode code, std::source_location where) {
  if (code == 0) return;
  const char* text = nullptr;
  char* specific = nullptr;
  PetscErrorMessage(code, &text, &specific);
  std::string message = "PETSc error " + std::to_string(static_cast<int>(code)) + " at " + place(where);
  if (text != nullptr) message += std::string(": ") + text;
  if (specific != nullptr && *specific != '\0') message += std::string(": ") + specific;
  throw PetscFailure(code, message);
}

void check_mpi(int code, std::source_location where) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw PetscFailure(PETSC_ERR_MPI, "MPI error at " + place(where) + ": " + std::string(text, length));
}

}  // namespace pliant
