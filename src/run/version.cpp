#include "run/version.hpp"

#include "solver/eigenpairs.hpp"
#include "solver/linear.hpp"

#include <algorithm>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gmsh.h>
#include <hdf5.h>
#include <metis.h>
#include <mpi.h>
#include <petscconf.h>
#include <petscsys.h>

namespace pliant {

std::string version_text() {
  char petsc[256] = "";
  (void)PetscGetVersion(petsc, sizeof petsc);
  std::string first_line = petsc;
  first_line.resize(std::min(first_line.size(), first_line.find(',')));
  char mpi[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  (void)MPI_Get_library_version(mpi, &length);
  std::string mpi_line(mpi, static_cast<std::size_t>(length));
  mpi_line.resize(std::min(mpi_line.size(), mpi_line.find(',')));
  unsigned major = 0, minor = 0, release = 0;
  (void)H5get_libversion(&major, &minor, &release);
  return fmt::format(
      "pliant {}\n  PETSc   {}\n  SLEPc   {}\n  MUMPS   {}\n  HDF5    {}\n  gmsh    {}\n  METIS   {}.{}.{}\n  MPI     "
      "{}\n",
      PLIANT_VERSION, first_line, slepc_version(), mumps_version(), fmt::format("{}.{}.{}", major, minor, release),
      GMSH_API_VERSION, METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR, mpi_line);
}

std::string commented(const std::string& text) {
  std::istringstream lines(text);
  std::string line, result;
  while (std::getline(lines, line)) result += "# " + line + "\n";
  return result;
}

}  // namespace pliant
