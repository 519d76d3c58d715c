#!/usr/bin/env bash
# Builds the fuzzers of everything that reads files (docs/developer/hygiene.md) and runs each.
#
#   tools/fuzz.sh [SECONDS [NAME ...]]      default: 60 seconds each of input, fit, msh, abaqus, nastran, medit, unv, vtk, vtu, med,
#                                         mesh_file, surface, triangles, result, checkpoint
#
# Starts from tests/fuzz/corpus and what earlier runs kept in build-fuzz/corpus. A finding ends the fuzzer; it lies in
# build-fuzz/findings and is shown again by: build-fuzz/bin/fuzz_NAME FILE
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

seconds=${1:-60}
[[ $seconds =~ ^[0-9]+$ ]] || fail "usage: tools/fuzz.sh [SECONDS [NAME ...]]"
names=("${@:2}")
((${#names[@]} > 0)) || names=(input fit msh abaqus nastran medit unv vtk vtu med mesh_file surface triangles result checkpoint)
fuzz=$root/build-fuzz

command -v clang++-16 >/dev/null || fail "clang is needed: apt-get install clang-16 libclang-rt-16-dev"
if [[ ! -e $fuzz/build.ninja ]]; then
  (cd "$root" && cmake --preset fuzz >/dev/null)
fi
ninja -C "$fuzz" -j "$(build_jobs)" "${names[@]/#/fuzz_}"

# Libraries keep what they allocated once until the process ends: leaks are the tests' business (tools/sanitize.sh). HDF5
# asks for what a file claims to hold before it looks whether so much is there, and lives with a no; `new` does not.
export ASAN_OPTIONS=detect_leaks=0:allocator_may_return_null=1:max_allocation_size_mb=1000:suppressions=$root/tests/sanitizers/libraries.txt UBSAN_OPTIONS=print_stacktrace=1
export OMPI_MCA_pml=ob1 OMPI_MCA_btl=self HWLOC_COMPONENTS=-gl
export OMPI_MCA_opal_signal=''  # libFuzzer reports signals, and keeps the file
if symbolizer=$(command -v llvm-symbolizer-16); then
  export ASAN_SYMBOLIZER_PATH=$symbolizer  # package llvm-16; without it findings have addresses for names
fi
mkdir -p "$fuzz/findings/of_hdf5"
status=0

# Puts the files of a name aside over which HDF5 itself crashes or takes gigabytes where that does no harm: in a process of
# its own, or behind a checksum. Those are to be tried with the program.
set_hdf5s_own_aside() {
  local file trace innermost
  for file in "$fuzz/findings/$1"-{crash,oom}-*; do
    [[ -e $file ]] || continue
    trace=$("$fuzz/bin/fuzz_$1" -malloc_limit_mb=200 "$file" 2>&1 | tr -d '\0' || true)
    innermost=$(grep -m 1 -o "$root/src/\|libhdf5" <<<"$trace" || true)
    if [[ $innermost == libhdf5 && ($1 == checkpoint || $trace == *pliant::in_child*) ]] ||
      [[ -z $innermost && $file == *-oom-* ]]; then  # the latter: what others had left in that process
      mv "$file" "$fuzz/findings/of_hdf5"
    fi
  done
}
for name in "${names[@]}"; do
  say "fuzzing $name for $seconds s"
  mkdir -p "$fuzz/corpus/$name"
  dictionary=()
  if [[ -e $root/tests/fuzz/$name.dict ]]; then
    dictionary=(-dict="$root/tests/fuzz/$name.dict")
  fi
  processes=()
  if [[ $name =~ ^(mesh_file|med|result|checkpoint)$ ]]; then
    # HDF5 crashes over some files, and keeps the memory of files that it cannot close: a new process then.
    processes=(-fork=1 -ignore_ooms=1 -ignore_crashes=1)
  fi
  code=0
  # A case takes milliseconds; one of 25 s is a hang, and one of 2 GB believed a number that it read.
  "$fuzz/bin/fuzz_$name" "$fuzz/corpus/$name" "$root/tests/fuzz/corpus/$name" "${dictionary[@]}" "${processes[@]}" -max_total_time="$seconds" \
    -timeout=25 -rss_limit_mb=2048 -malloc_limit_mb=1000000 -max_len=20000 -print_final_stats=1 -verbosity=0 -artifact_prefix="$fuzz/findings/$name-" ||
    code=$?
  if ((${#processes[@]} > 0)); then
    [[ $code =~ ^(71|77)$ ]] && code=0  # its last process found something; the files that stay decide whether that counts
    set_hdf5s_own_aside "$name"
  fi
  ((code == 0)) || status=1
  if compgen -G "$fuzz/findings/$name-*" >/dev/null; then
    say "fuzzing $name found something: $fuzz/findings"
    status=1
  fi
done
exit "$status"
