#!/usr/bin/python3
"""Checks names in src/ and tests/ by the rules of .clang-tidy, as build/ compiles them.

  tools/check_naming.py [--build DIR] [--all-checks] [FILE.cpp ...]      without files: all

Most of clang-tidy's time goes into library headers, so the sources of a folder are checked as one translation unit; those that do not
compile together (the same local name in two files) are halved until they do. --all-checks adds the checks of likely mistakes: minutes.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CLANG_TIDY = "clang-tidy-16"  # the first that knows std::source_location
QUIET = re.compile(r"^(\d+ warnings?( and \d+ errors?)? generated\.|Error while processing .*|)$")


def commands(build):
    """Source file -> its compile options (without compiler, output and input)."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        file = pathlib.Path(entry["file"])
        if ROOT in file.parents:
            output = words.index("-o")
            found[file] = [word for word in words[1:output] if word != "-c"]
    return found


def tidy(file, options, checks):
    """clang-tidy's complaints on a file as lines; -w: warnings are the compiler's business."""
    command = [CLANG_TIDY, "--quiet", f"--config-file={ROOT / '.clang-tidy'}", *checks, str(file), "--", *options, "-w"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    noise = [line for line in done.stderr.splitlines() if not QUIET.match(line)]
    return done.stdout.splitlines() + (noise if done.returncode and not done.stdout else [])


def tidy_together(files, options, checks):
    if len(files) == 1:
        return tidy(files[0], options, checks)
    with tempfile.TemporaryDirectory() as folder:
        unit = pathlib.Path(folder) / "unit.cpp"
        unit.write_text("".join(f'#include "{file}"\n' for file in files))
        complaints = tidy(unit, options, checks)
    if any("clang-diagnostic-error" in line for line in complaints):
        half = len(files) // 2
        return tidy_together(files[:half], options, checks) + tidy_together(files[half:], options, checks)
    return complaints


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="the configured build folder")
    parser.add_argument("--all-checks", action="store_true", help="not names only, but everything in .clang-tidy")
    parser.add_argument("files", type=pathlib.Path, nargs="*", metavar="FILE.cpp")
    arguments = parser.parse_args()
    try:
        options_of = commands(arguments.build)
    except OSError as error:
        sys.exit(f"{error.filename}: {error.strerror}; configure first: tools/setup.sh test")
    chosen = {file.resolve() for file in arguments.files} or set(options_of)
    if chosen - set(options_of):
        sys.exit(f"not compiled in {arguments.build}: " + " ".join(str(file) for file in chosen - set(options_of)))
    groups = {}
    for file in sorted(chosen):
        groups.setdefault((file.parent, tuple(options_of[file])), []).append(file)
    checks = [] if arguments.all_checks else ["--checks=-*,readability-identifier-naming"]
    # Largest first, so that no core is left with the longest alone.
    work = sorted(groups.items(), key=lambda group: -sum(file.stat().st_size for file in group[1]))
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        results = pool.map(lambda group: tidy_together(group[1], group[0][1], checks), work)
        complaints = list(dict.fromkeys(line for lines in results for line in lines))
    print("\n".join(complaints) if complaints else f"{len(chosen)} sources follow .clang-tidy")
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
