#!/usr/bin/env bash
# Builds the site of the documents in build/docs/html: the pages of docs/, and the C++ reference. Warnings are errors.
#
#   tools/docs.sh [DIRECTORY]      another directory than build/docs/html
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
html=$(realpath -m "${1:-$root/build/docs/html}")
for tool in sphinx-build doxygen; do
  command -v "$tool" >/dev/null || {
    echo "$tool is missing: tools/setup.sh packages test" >&2
    exit 1
  }
done

cd "$root"
mkdir -p "$html"
PLIANT_DOCS=$html doxygen docs/Doxyfile
# The modules are Debian's; another python3 may come first on PATH.
/usr/bin/python3 -m sphinx -W --keep-going -q -b html -d "$html/../doctrees" docs "$html"
echo "$html/index.html"
