#!/usr/bin/env bash
# Which lines of src/ the tests of the layers run: build-coverage/coverage/index.html, and a summary per file.
#
#   tools/coverage.sh [LAYER ...]      default: base petsc material mesh time io app
#
# Needs: apt-get install gcovr. The kernels of fem, energy and solver are slow to build without optimisation; name them
# to have them, too. Lines that are run by tests/program alone count as not run: those tests start the release build.
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

layers=("$@")
((${#layers[@]} > 0)) || layers=(base petsc material mesh time io app)
command -v gcovr >/dev/null || fail "gcovr is needed: apt-get install gcovr"
covered=$root/build-coverage
if [[ ! -e $covered/build.ninja ]]; then
  (cd "$root" && cmake --preset coverage >/dev/null)
fi
ninja -C "$covered" -j "$(build_jobs)" "${layers[@]/#/test_}"
find "$covered" -name '*.gcda' -delete
for layer in "${layers[@]}"; do
  for ranks in 1 2; do
    say "running $layer on $ranks"
    on_ranks "$ranks" "$covered/bin/test_$layer" --gtest_brief=1 || say "a test of $layer failed; its lines count nevertheless"
  done
done
mkdir -p "$covered/coverage"
gcovr --root "$root" --filter "$root/src/" --object-directory "$covered" --exclude-throw-branches --gcov-ignore-parse-errors \
  --html-details "$covered/coverage/index.html" --txt "$covered/coverage/summary.txt" --print-summary "$covered"
say "in $covered/coverage: index.html, summary.txt"
