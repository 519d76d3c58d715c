#!/usr/bin/env bash
# Everything that must be there before Pliant runs: Debian packages, the configured build folder, the compiled program.
#
#   tools/setup.sh run     what the program and its pictures need     (tools/run.sh calls this)
#   tools/setup.sh test    also what the tests need                   (tools/test.sh calls this)
#   tools/setup.sh packages run|test    installs the packages only; `list` instead of `packages` prints their names
#
# Does only what is missing. Root is needed for missing packages only. May be sourced for its functions.
set -euo pipefail

# The packages, for Debian 12: what compiling needs, and what else running and testing need.
build_packages=(
  g++ cmake ninja-build pkg-config git
  libpetsc-real-dev libslepc-real-dev libgmsh-dev gmsh libmetis-dev libhdf5-openmpi-dev libopenmpi-dev openmpi-bin
  libopenblas0-pthread libopenblas-dev libyaml-cpp-dev libcli11-dev libfmt-dev libmuparser-dev
  libudunits2-dev nlohmann-json3-dev libeigen3-dev libboost-dev zlib1g-dev
  python3 python3-dev pybind11-dev
)
run_packages=(python3-numpy python3-vtk9 python3-matplotlib python3-h5py python3-yaml python3-pil ffmpeg xvfb)
test_build_packages=(libgtest-dev libbenchmark-dev)
test_packages=(
  python3-jsonschema clang-format-14 clang-tidy-16 chromium python3-meshio python3-scipy python3-mpi4py
  python3-petsc4py dpkg-dev file groff-base doxygen python3-pip python3-venv python3-sphinx python3-myst-parser furo
)
# The page of `pliant report` is put together by npm. Where there is one already it may come with a nodejs that is not
# Debian's, which excludes Debian's npm.
if ! command -v npm >/dev/null; then
  build_packages+=(npm)
fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
build=$root/build
# shellcheck disable=SC2034  # for those who source this
python=/usr/bin/python3  # Debian's, which sees Debian's modules; another one may come first on PATH

list_is_new=false  # that of the packages there are

say() { printf 'pliant: %s\n' "$*"; }

fail() {
  printf 'pliant: %s\n' "$*" >&2
  exit 1
}

# packages_for run|test [build]: one name per line; with `build`, those that compiling needs.
packages_for() {
  local names=("${build_packages[@]}")
  if [[ $1 == test ]]; then
    names+=("${test_build_packages[@]}")
  fi
  case $1-${2:-all} in
    run-build | test-build) ;;
    run-all) names+=("${run_packages[@]}") ;;
    test-all) names+=("${run_packages[@]}" "${test_packages[@]}") ;;
    *) fail "expected 'run' or 'test', not '$1'" ;;
  esac
  printf '%s\n' "${names[@]}"
}

missing_packages() {
  local wanted
  mapfile -t wanted < <(packages_for "$@")
  # dpkg-query fails when it does not know a name; such a name is missing too.
  comm -23 <(printf '%s\n' "${wanted[@]}" | sort) \
    <({ dpkg-query -W -f '${Package} ${db:Status-Status}\n' "${wanted[@]}" 2>/dev/null || true; } |
      sed -n 's/ installed$//p' | sort -u)
}

# install_packages run|test [build]
install_packages() {
  if ! command -v dpkg-query >/dev/null; then
    say "this is not a Debian system; the following must be installed already: $(packages_for "$@" | tr '\n' ' ')"
    return
  fi
  local missing as_root=()
  mapfile -t missing < <(missing_packages "$@")
  if ((${#missing[@]} == 0)); then
    return
  fi
  say "installing ${#missing[@]} packages: ${missing[*]}"
  if ((EUID != 0)); then
    command -v sudo >/dev/null || fail "root is needed for that: apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
    if [[ ! -t 0 ]]; then
      as_root=(sudo -n)  # nobody is there to type a password
    fi
  fi
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q
    -o Acquire::Retries=3 -o DPkg::Lock::Timeout=600 -o Dpkg::Use-Pty=0)
  local quietly=/dev/null
  if [[ -t 0 ]]; then
    quietly=/dev/tty  # sudo may ask for a password
  fi
  "$list_is_new" || "${apt[@]}" update <$quietly >/dev/null || say "the list of packages could not be updated; continuing with the old one"
  list_is_new=true
  "${apt[@]}" install -y --no-install-recommends "${missing[@]}" <$quietly >/dev/null ||
    fail "the packages could not be installed; on Debian 12, as root: apt-get install --no-install-recommends ${missing[*]}"
}

# The direct solver spends its time in BLAS, and Debian's reference BLAS is about ten times slower than OpenBLAS.
warn_of_slow_blas() {
  local library
  for library in /usr/lib/*/libblas.so.3; do
    if [[ $(readlink -f "$library") == */blas/libblas.so.3* ]]; then
      local name=${library#/usr/lib/}
      say "warning: BLAS is the slow reference one ($library)"
      say "         cure: sudo update-alternatives --auto libblas.so.3-${name%%/*}"
    fi
  done
}

# Cores that may be used; plain nproc would take OMP_NUM_THREADS for their number.
usable_cores() { env -u OMP_NUM_THREADS -u OMP_THREAD_LIMIT nproc; }

# Compile jobs at once: one per core, as far as 1.5 GB of memory each go.
build_jobs() {
  local cores memory limit
  cores=$(usable_cores)
  memory=$(awk '/^MemAvailable:/ {print int($2 / 1024)}' /proc/meminfo)
  if [[ -r /sys/fs/cgroup/memory.max ]]; then
    limit=$(</sys/fs/cgroup/memory.max)
    if [[ $limit =~ ^[0-9]+$ ]] && ((limit / 1048576 < memory)); then
      memory=$((limit / 1048576))
    fi
  fi
  local jobs=$((memory / 1500))
  ((jobs < cores)) || jobs=$cores
  ((jobs > 0)) || jobs=1
  echo "$jobs"
}

cached() { sed -n "s/^$1:[A-Z]*=//p" "$build/CMakeCache.txt" 2>/dev/null || true; }

# The program alone needs no test packages; a build folder once configured with tests keeps them.
configure() {
  local options=()
  if [[ $1 == run && $(cached PLIANT_TESTS) != ON ]]; then
    options=(-DPLIANT_TESTS=OFF -DPLIANT_BENCHMARKS=OFF)
  elif [[ $1 == test ]]; then
    options=(-DPLIANT_TESTS=ON -DPLIANT_BENCHMARKS=ON)
  fi
  if [[ -e $build/CMakeCache.txt && $(cached CMAKE_HOME_DIRECTORY) != "$root" ]]; then
    options+=(--fresh)  # the clone was moved
  elif [[ -e $build/build.ninja && ($1 == run || $(cached PLIANT_TESTS) == ON) ]]; then
    return
  fi
  say "configuring $build"
  (cd "$root" && cmake --preset release "${options[@]}" </dev/null >"$log" 2>&1) || {
    cat "$log" >&2
    fail "cmake failed"
  }
}

compile() {
  local jobs targets=()
  jobs=$(build_jobs)
  if [[ $1 == run ]]; then
    targets=(pliant_program)
  fi
  say "building with $jobs jobs at once"
  ninja -C "$build" -j "$jobs" "${targets[@]}" </dev/null || fail "the build failed"
}

# set_up run|test
set_up() {
  local installing=
  install_packages "$1" build
  if ((EUID == 0)); then
    install_packages "$1" </dev/null &  # while the program compiles, which does not need these
    installing=$!
  else
    install_packages "$1"  # sudo may ask for a password
  fi
  warn_of_slow_blas
  log=$(mktemp)
  trap 'wait; rm -f "$log"' EXIT
  configure "$1"
  compile "$1"
  wait $installing || exit 1
}

if [[ ${BASH_SOURCE[0]} == "$0" ]]; then
  case ${1:-} in
    run | test) set_up "$1" ;;
    packages) install_packages "${2:-test}" ;;
    list) packages_for "${2:-test}" ;;
    *) fail "usage: tools/setup.sh run | test | packages [run|test] | list [run|test]" ;;
  esac
fi
