#!/usr/bin/env bash
# Checks that src/, tests/ and docs/examples/ are formatted as .clang-format says; `tools/check_format.sh --fix` formats them.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mode=(--dry-run -Werror)
if [[ ${1:-} == --fix ]]; then
  mode=(-i)
fi
find src tests docs/examples -name '*.[ch]pp' -print0 | xargs -0 -P "$(nproc)" -n 16 clang-format-14 --style=file "${mode[@]}"
