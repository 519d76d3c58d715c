#!/usr/bin/env bash
# Sets up what is missing and runs the tests; ends with ctest's summary.
#
#   tools/test.sh [CTEST OPTION ...]           e.g. tools/test.sh -R time
#   tools/test.sh --long [CTEST OPTION ...]    with what takes long: PLIANT_LONG_TESTS=1
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

patience=900  # seconds for each entry
if [[ ${1:-} == --long ]]; then
  shift
  export PLIANT_LONG_TESTS=1
  patience=20000
fi

set_up test
say "testing"
ctest --test-dir "$build" --output-on-failure --no-tests=error --timeout "$patience" -j "$(usable_cores)" "$@" </dev/null
