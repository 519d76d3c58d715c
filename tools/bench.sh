#!/usr/bin/env bash
# Measures whole runs of a beam in Pliant against dolfinx: same mesh, law, tolerance and step, one after the other in one
# session, and prints a table of seconds per step and ratios. Takes minutes; let nothing else run meanwhile.
#
#   tools/bench.sh                          the beam, sizes S and M, one rank and two
#   tools/bench.sh --sizes S M L M2         further sizes; --variants beam stiff bulky, --repeats 3
#   tools/bench.sh --write                  the table goes to docs/performance.md too
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"
exec /usr/bin/python3 "$root/tools/bench.py" "$@"
