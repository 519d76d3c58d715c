#!/usr/bin/env bash
# Which lines of src/ the tests run: build-coverage/coverage/index.html, and a summary per file and per layer.
#
#   tools/coverage.sh [LAYER | program ...]       default: all, e.g. tools/coverage.sh mesh program
#
# `program`: the tests of the program that are about errors, faults, resuming and output.
# Needs: apt-get install gcovr
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

layers=("$@")
((${#layers[@]} > 0)) || layers=(base petsc material mesh fem time energy multigrid solver io input model run study command program)
program_tests=(test_errors test_faults test_meshes test_commands test_post_mortem test_restart test_outputs test_interruption
  test_sweep test_convergence test_report test_shell test_cavities test_constraints test_muscle test_materials test_loads)
command -v gcovr >/dev/null || fail "gcovr is needed: apt-get install gcovr"
covered=$root/build-coverage
if [[ ! -e $covered/build.ninja ]]; then
  (cd "$root" && cmake --preset coverage >/dev/null)
fi
targets=("${layers[@]/#/test_}")
ninja -C "$covered" -j "$(build_jobs)" "${targets[@]/test_program/pliant_program}"
find "$covered" -name '*.gcda' -delete
for layer in "${layers[@]}"; do
  if [[ $layer == program ]]; then
    say "running the program"
    for test in "${program_tests[@]}"; do
      (cd "$root/tests/program" && PLIANT=$covered/bin/pliant "$python" -B -m unittest -q "$test") ||
        say "$test failed; its lines count nevertheless"
    done
    continue
  fi
  for ranks in 1 2; do
    say "running $layer on $ranks"
    on_ranks "$ranks" "$covered/bin/test_$layer" --gtest_brief=1 || say "a test of $layer failed; its lines count nevertheless"
  done
done
mkdir -p "$covered/coverage"
lines=$covered/coverage/lines.json
gcovr --root "$root" --filter "$root/src/" --object-directory "$covered" --exclude-throw-branches --gcov-ignore-parse-errors \
  --json "$lines" "$covered"
gcovr --root "$root" --add-tracefile "$lines" --html-details "$covered/coverage/index.html" --txt "$covered/coverage/summary.txt"
for layer in "$root"/src/*/; do
  compgen -G "$layer*.cpp" >/dev/null || continue
  printf '%-10s' "$(basename "$layer")"
  gcovr --root "$root" --filter "$layer" --add-tracefile "$lines" --print-summary --output "$covered/coverage/layer.txt" | grep '^lines'
done
say "in $covered/coverage: index.html, summary.txt"
