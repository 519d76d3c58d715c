/// The kernels with which OpenBLAS computes.
#pragma once

namespace pliant {

/// A function of the BLAS in this process, wherever it was loaded; nullptr if it has none of this name: another BLAS
/// may replace OpenBLAS.
void* symbol_of_blas(const char* name);

/// The kernels that fit the processor, where OpenBLAS has chosen those for the oldest one and the user has chosen none;
/// else nullptr.
const char* better_blas_kernels();

/// Has OpenBLAS compute with kernels that fit the processor, where it has chosen those for the oldest one: a version
/// older than the processor does not know it (0.3.21 of Debian 12 and Sapphire Rapids or newer), and factorizations
/// take 1.7 times as long. OpenBLAS reads the variable OPENBLAS_CORETYPE as it is loaded, and once more where it lets
/// itself be asked; else the program restarts itself. A user's choice of the variable stays. To be called first in
/// `main`. Returns where there is nothing more to do, or if the restart fails.
void take_fitting_blas_kernels(char** argv);

}  // namespace pliant
