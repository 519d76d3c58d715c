#!/usr/bin/env bash
# Sets up what is missing, runs a simulation and makes a picture of it.
#
#   tools/run.sh [OPTION ...]              the demo, input/gripper_finger.yaml, on two ranks
#   tools/run.sh INPUT.yaml [OPTION ...]   another input; options are those of `pliant run`
#
# PLIANT_RANKS sets the number of ranks. Returns what the program returns.
set -euo pipefail
# shellcheck source=tools/setup.sh
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh"
# shellcheck source=tools/environment.sh
source "$root/tools/environment.sh"

ranks=${PLIANT_RANKS:-2}
[[ $ranks =~ ^[1-9][0-9]*$ ]] || fail "PLIANT_RANKS must be a number of ranks, not '$ranks'"

case ${1:-} in
  -h | --help)
    sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//;p}' "${BASH_SOURCE[0]}"
    exit
    ;;
  '' | -*) set -- "$root/input/gripper_finger.yaml" --output "$root/out/gripper_finger" "$@" ;;
esac

# output_directory INPUT [OPTION ...]: where the program will put the results, by the rules of `pliant run`.
output_directory() {
  "$python" - "$@" <<'PYTHON'
import pathlib
import sys

import yaml

directory = None
options = sys.argv[2:]
for option, value in zip(options, options[1:] + [""]):
    if option == "--":
        break
    for prefix in ("--output=", "--set=output.directory=", "output.directory="):
        if option.startswith(prefix):
            directory = option[len(prefix):]
    if option in ("-o", "--output"):
        directory = value
if directory is None:
    with open(sys.argv[1], encoding="utf-8") as file:
        directory = (yaml.safe_load(file).get("output") or {}).get("directory")
print(directory or pathlib.Path("out") / pathlib.Path(sys.argv[1]).stem)
PYTHON
}

set_up run
say "running $1 on $ranks rank(s)"
status=0
on_ranks "$ranks" "$build/bin/pliant" run "$@" </dev/null || status=$?
if ((status != 0)); then
  exit "$status"
fi
directory=$(output_directory "$@")
"$build/bin/pliant" report "$directory" </dev/null || true  # without npm there are pictures all the same
say "drawing $directory"
file=$("$build/bin/pliant" render "$directory" </dev/null | tail -n 1)
echo "picture: $file"
