#!/usr/bin/env bash
# Looks for errors without running anything: clang-tidy with all of .clang-tidy, and cppcheck. Minutes.
#
#   tools/check_static.sh [FILE.cpp ...]      default: all
#
# Needs the configured build folder, and: apt-get install clang-tidy-16 cppcheck
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"

status=0
"$python" "$root/tools/check_naming.py" --build "$build" --all-checks "$@" || status=1

command -v cppcheck >/dev/null || fail "cppcheck is needed: apt-get install cppcheck"
# It knows neither headers of libraries nor C++20's structured bindings and lambdas well; what it takes wrongly:
# - danglingTempReference, returnDanglingLifetime: references bound by a conditional expression, and indices that it
#   takes for iterators
# - useInitializationList and the like are not asked for: style is clang-tidy's
files=("$@")
((${#files[@]} > 0)) || files=("$root/src")
cppcheck --quiet --enable=warning,performance,portability --std=c++20 --inline-suppr -j "$(usable_cores)" -I "$root/src" \
  --suppress=missingInclude --suppress=unknownMacro --suppress=danglingTempReference --suppress=returnDanglingLifetime \
  --error-exitcode=1 --template='{file}:{line}: {severity}: {message} [{id}]' "${files[@]}" || status=1
exit "$status"
