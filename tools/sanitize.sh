#!/usr/bin/env bash
# Runs the tests of the layers, and some of the program, under the address, undefined-behaviour and leak sanitizers, in a
# build folder of their own.
#
#   tools/sanitize.sh [LAYER | program ...]       default: all, e.g. tools/sanitize.sh mesh io
#
# Layers whose ranks do different work run on two ranks, too.
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

layers=("$@")
((${#layers[@]} > 0)) || layers=(base petsc material mesh fem time energy multigrid solver io input model run study command fuzz program)
# One of each kind: steps, contact, cavities, resuming, meshes.
program_tests=(test_loads.Loads.test_dashpots_brake_a_body test_contact.Contact.test_{slope,ranks_agree}
  test_cavities.Cavities.test_{gas_swings_with_the_tube_and_keeps_its_law,liquid_flows_in}
  test_restart.Continuation.test_{elsewhere,a_later_end_and_another_step} test_meshes
  test_errors.Errors.test_mistakes_against_the_mesh)
sanitized=$root/build-asan
if [[ ! -e $sanitized/build.ninja ]]; then
  (cd "$root" && cmake --preset asan >/dev/null)
fi
targets=("${layers[@]/#/test_}")
ninja -C "$sanitized" -j "$(build_jobs)" "${targets[@]/test_program/pliant_program}"

# fork() of a process that holds this much address space is refused where memory may not be overcommitted, and gmsh runs
# in a child: a smaller quarantine. Leaks of the libraries are named in the list, each with its reason.
export ASAN_OPTIONS=detect_leaks=1:quarantine_size_mb=64
export LSAN_OPTIONS=suppressions=$sanitized/leaks.txt:print_suppressions=0
export UBSAN_OPTIONS=print_stacktrace=1 HWLOC_COMPONENTS=-gl
export LD_LIBRARY_PATH=$sanitized/lib  # dlopen() of the sanitizer's does not look where the program says
status=0
for layer in "${layers[@]}"; do
  cp "$root/tests/sanitizers/leaks.txt" "$sanitized/leaks.txt"
  if [[ $layer == program ]]; then
    say "sanitizing the program"
    export PLIANT=$sanitized/bin/pliant
    # Where PETSc refuses an option of the user's, it loses what it held; the process ends then.
    (cd "$root/tests/program" && "$python" -B -m unittest -q "${program_tests[@]}" &&
      ASAN_OPTIONS=${ASAN_OPTIONS/detect_leaks=1/detect_leaks=0} "$python" -B -m unittest -q \
        test_errors.Errors.test_bad_command_lines) ||
      { say "FAILED: the program"; status=1; }
    continue
  fi
  counts=(1) asan=$ASAN_OPTIONS
  case $layer in
    petsc | mesh | fem | energy | io) counts=(1 2) ;;
    fuzz)  # of damaged files HDF5 believes sizes that cannot be had, and loses blocks of what it cannot close
      asan+=:allocator_may_return_null=1:suppressions=$root/tests/sanitizers/libraries.txt
      echo leak:libhdf5 >>"$sanitized/leaks.txt"
      ;;
  esac
  for ranks in "${counts[@]}"; do
    say "sanitizing $layer on $ranks"
    ASAN_OPTIONS=$asan on_ranks "$ranks" "$sanitized/bin/test_$layer" --gtest_brief=1 ||
      { say "FAILED: $layer on $ranks"; status=1; }
  done
done
exit "$status"
