#!/usr/bin/python3
"""Checks names in src/ and tests/ by the rules of .clang-tidy, as build/ compiles them.

  tools/check_naming.py [--build DIR] [--all-checks] [--changed | FILE.cpp ...]      without files: all

Most of clang-tidy's time goes into headers, so all sources of src/ are checked as one translation unit, and all of tests/. Their unnamed
namespaces get different names for that. Sources that clash nevertheless are named and checked one by one, which takes seconds for each;
another name in one of them saves the time. All take ten minutes; --changed checks what the last commits changed, and what is not
committed, unless PLIANT_LONG_TESTS is set. --all-checks adds the checks for likely errors: minutes.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CLANG_TIDY = "clang-tidy-16"  # the first that knows std::source_location
RECENT = 5  # commits
QUIET = re.compile(r"^(\d+ warnings?( and \d+ errors?)? generated\.|Error while processing .*|)$")


def sources_of(file):
    """A file, or those that it includes if CMake wrote it to compile several at once."""
    if file.parent.name != "Unity":
        return [file]
    return [pathlib.Path(name) for name in re.findall(r'^#include "(.*)"', file.read_text(), flags=re.MULTILINE)]


def commands(build):
    """Source file -> its compile options (without compiler, output and input), an option with a separate value as one entry."""
    found = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        options = iter(word for word in words[words[0].endswith("ccache") + 1 : words.index("-o")] if word != "-c")
        options = [(word, next(options)) if word == "-isystem" else (word,) for word in options]
        found |= {file: options for file in sources_of(pathlib.Path(entry["file"])) if ROOT in file.parents}
    return found


def git(*arguments):
    return subprocess.run(["git", "-C", ROOT, *arguments], capture_output=True, text=True, check=True).stdout.splitlines()


def changed(sources):
    """The sources that changed since RECENT commits, and for each header that did one that includes it."""
    try:
        before = git("rev-list", "--first-parent", f"--max-count={RECENT + 1}", "HEAD")[-1]
        names = git("diff", "--name-only", before) + git("ls-files", "--others", "--exclude-standard")
    except subprocess.CalledProcessError:
        return sources  # not in a repository
    files = {ROOT / name for name in names}
    found = files & sources
    for header in sorted(file for file in files if file.suffix == ".hpp" and file.exists()):
        includes = re.compile(rf'^#include "(.*/)?{re.escape(header.name)}"', re.MULTILINE)
        users = {file for file in sources if includes.search(file.read_text())}
        if users and not users & found:
            found.add(min(users, key=lambda file: (file.stem != header.stem, file.stat().st_size, file)))
    return found


def tidy(file, options, checks):
    """clang-tidy's findings on a file, each with its notes; -w: warnings are the compiler's business."""
    # The configuration is the one that stands next to a file, and there is none next to libraries: their names cost no time.
    command = [CLANG_TIDY, "--quiet", *checks, str(file), "--", *options, "-w", "-ferror-limit=0"]
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    findings = re.split(r"^(?=/.*?:\d+:\d+: (?:error|warning): |error: )", done.stdout, flags=re.MULTILINE)
    noise = [line for line in done.stderr.splitlines() if not QUIET.match(line)]
    return [text for text in findings if text] + (noise if done.returncode and not done.stdout else [])


def with_named_namespace(text, name):
    """A source whose unnamed namespace has a name, seen from outside of it only if something stands there."""
    ends = re.search(r"^}  // namespace\n}  // namespace pliant\S*\n\Z", text, flags=re.MULTILINE)
    use = "" if ends else f"namespace {name} {{}} using namespace {name}; "
    return re.sub(r"^namespace \{$", f"{use}namespace {name} {{", text, flags=re.MULTILINE)


def unit_of(files, folder):
    """Writes one translation unit of all files; returns it, and by file the copy that it includes."""
    shutil.copy(ROOT / ".clang-tidy", folder)
    copies = {}
    headers = {}
    for number, file in enumerate(files):
        text = file.read_text()
        headers |= dict.fromkeys(re.findall(r'^#include "(.*/.*)"', text, flags=re.MULTILINE))
        copies[file] = folder / file.relative_to(ROOT)
        copies[file].parent.mkdir(parents=True, exist_ok=True)
        copies[file].write_text(with_named_namespace(text, f"unit_{number}"))
    unit = folder / "unit.cpp"
    # Headers come first: what a source defines cannot spoil them.
    unit.write_text("".join(f'#include "{file}"\n' for file in [*sorted(headers), *copies.values()]))
    return unit, copies


def tidy_together(files, options_of, checks):
    """Findings on all files, and those of the files that must be checked by themselves: what others define spoils them."""
    if len(files) == 1:
        return tidy(files[0], [word for option in options_of[files[0]] for word in option], checks), []
    options = [f"-iquote{folder}" for folder in dict.fromkeys(file.parent for file in files)]
    options += [word for option in dict.fromkeys(option for file in files for option in options_of[file]) for word in option]
    with tempfile.TemporaryDirectory() as folder:
        unit, copies = unit_of(files, pathlib.Path(folder))
        findings = tidy(unit, options, checks)
    errors = {text.split(":", 1)[0] for text in findings if "[clang-diagnostic-error" in text}
    clashing = [file for file in files if str(copies[file]) in errors]
    spoilt = tuple(f"{copies[file]}:" for file in clashing)
    return [text.replace(folder, str(ROOT)) for text in findings if not text.startswith(spoilt)], clashing


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build", help="the configured build folder")
    parser.add_argument("--all-checks", action="store_true", help="not names only, but everything in .clang-tidy")
    parser.add_argument("--changed", action="store_true", help="what the last commits changed, or is not committed")
    parser.add_argument("files", type=pathlib.Path, nargs="*", metavar="FILE.cpp")
    arguments = parser.parse_args()
    try:
        options_of = commands(arguments.build)
    except OSError as error:
        sys.exit(f"{error.filename}: {error.strerror}; configure first: tools/setup.sh test")
    chosen = {file.resolve() for file in arguments.files} or set(options_of)
    if arguments.changed and not os.environ.get("PLIANT_LONG_TESTS"):
        chosen = changed(chosen)
    if chosen - set(options_of):
        sys.exit(f"not compiled in {arguments.build}: " + " ".join(str(file) for file in chosen - set(options_of)))
    groups = {}
    for file in sorted(chosen):
        groups.setdefault(file.relative_to(ROOT).parts[0], []).append(file)
    checks = [] if arguments.all_checks else ["--checks=-*,readability-identifier-naming"]
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        results = list(pool.map(lambda files: tidy_together(files, options_of, checks), groups.values()))
        apart = [file for _, files in results for file in files]
        if apart:
            print("checked by themselves, for they clash with others:", *(file.relative_to(ROOT) for file in apart))
        results += pool.map(lambda file: tidy_together([file], options_of, checks), apart)
    findings = list(dict.fromkeys(text.rstrip("\n") for texts, _ in results for text in texts))
    print("\n".join(findings) if findings else f"{len(chosen)} sources follow .clang-tidy")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
