# shellcheck shell=bash
# How programs are started on several ranks; to be sourced.

# One thread per rank: the ranks are the parallelism.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
# Open MPI does not start as root unless both variables are set.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1

# on_ranks N PROGRAM [ARGUMENT ...]: returns what the program returns.
on_ranks() {
  local ranks=$1 cores processors options=(--quiet --bind-to none)
  shift
  if ((ranks == 1)); then
    "$@"
    return
  fi
  processors=$(env -u OMP_NUM_THREADS nproc)
  cores=$(lscpu --parse=CORE,SOCKET | grep -v '^#' | sort -u | wc -l)  # Open MPI counts cores, not hardware threads
  if ((cores < ranks || processors < ranks)); then
    options+=(--oversubscribe)
  fi
  mpirun -n "$ranks" "${options[@]}" "$@"
}
