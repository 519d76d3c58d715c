#!/usr/bin/env bash
# Sets up what is missing and runs all tests; ends with ctest's summary.
#
#   tools/test.sh [CTEST OPTION ...]       e.g. tools/test.sh -R time
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

set_up test
say "testing"
ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$(usable_cores)" "$@" </dev/null
