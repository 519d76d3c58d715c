#!/usr/bin/python3
"""Checks that includes run downward only: every `#include "layer/..."` in src/ against the table below, and no file cycles. Checks
also that every source has a header of its own, which says what the source implements.

Prints `file:line: what is wrong` and returns 1 when something is. With an argument: that folder instead of src/.
The table is the design; change it on purpose, in its own commit (docs/developer/architecture.md shows it too).
"""
import pathlib
import re
import sys

LAYERS = {
    "base": "",
    "petsc": "base",
    "material": "base",
    "collision": "base",
    "mesh": "petsc base",
    "fem": "mesh petsc base",
    "time": "petsc base",
    "multigrid": "petsc base",
    "energy": "fem material time collision petsc base",
    "solver": "energy multigrid time petsc base",
    "io": "fem mesh time petsc base",
    "input": "material time petsc base",
    "model": "input solver energy time fem mesh collision material petsc base",
    "run": "model input io solver energy time fem mesh material petsc base",
    "study": "run model input io solver energy time fem mesh material petsc base",
    "binding": "run model input io solver energy time fem mesh material petsc base",
    "command": "study run model input io solver energy time fem mesh material petsc base",
}
# The rooms of a layer, folders in it, and which others of them each may include. Files outside the rooms are common to them: all
# may include them, and they none.
ROOMS = {
    "energy": {
        "volume": "",
        "load": "",
        "contact": "",
        "rigid": "",
        "rod": "volume",
        "shell": "volume",
        "pairs": "",
        "constraint": "rigid volume",
        "equation": "constraint pairs rigid volume",
    },
}
# Sources that need no header: programs, and those that implement parts of another header still.
WITHOUT_HEADER = {"base/formula_tree_reader.cpp", "energy/constraint/mechanism_columns.cpp", "energy/constraint/mechanism_forces.cpp", "model/constraint_reactions.cpp", "energy/constraint/rigid_part_given.cpp", "energy/rod/rods_start.cpp", "energy/contact/touching_penalty.cpp", "binding/module.cpp", "command/main.cpp", "command/command_line_python.cpp", "command/command_line_studies.cpp", "solver/petsc_integrator_start.cpp"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')


def includes(file):
    """Yields (line, include) of Pliant's own headers."""
    for number, text in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
        match = INCLUDE.match(text)
        if match and (match[1] == '"' or match[2].split("/")[0] in LAYERS and "/" in match[2]):
            yield number, match[1], match[2]


def folder_of(name):
    return name.rsplit("/", 1)[0]


def room_of(name):
    """The folder of a file within its layer; "" outside the rooms."""
    return folder_of(name).partition("/")[2]


def may_enter(rooms, here, there):
    return there in ("", here) or here != "" and there in rooms.get(here, "").split()


def check(source):
    """All errors of the tree as lines of text."""
    errors = []
    graph = {}
    for file in sorted(path for path in source.rglob("*") if path.suffix in (".cpp", ".hpp", ".h", ".c")):
        name = file.relative_to(source).as_posix()
        layer = name.split("/")[0]
        graph[name] = {}
        if layer not in LAYERS or layer == name:
            errors.append(f"{file}:1: '{layer}' is not a layer; the layers are: {', '.join(LAYERS)}")
            continue
        if file.suffix == ".cpp" and name not in WITHOUT_HEADER and not file.with_suffix(".hpp").is_file():
            errors.append(f"{file}:1: there is no {file.stem}.hpp; declare what the source implements in a header of its name")
        allowed = {layer, *LAYERS[layer].split()}
        for line, quote, target in includes(file):
            place = f"{file}:{line}:"
            target_layer = target.split("/")[0]
            if quote == "<":
                errors.append(f'{place} write "{target}" for a header of Pliant')
            elif not (source / target).is_file():
                errors.append(f"{place} there is no src/{target}; name a header as \"layer/file.hpp\"")
            elif target_layer not in allowed:
                may = LAYERS[layer] or "nothing"
                errors.append(f"{place} layer '{layer}' may not include layer '{target_layer}' (it may include: {may})")
            elif target_layer == layer and layer in ROOMS and not may_enter(ROOMS[layer], room_of(name), room_of(target)):
                errors.append(f"{place} '{folder_of(name)}' may not include '{folder_of(target)}'")
            graph[name][target] = line
    return errors + cycles(source, graph)


def cycles(source, graph):
    """One line for every include that closes a cycle of files."""
    errors, done = [], set()

    def visit(name, path):
        for target, line in graph.get(name, {}).items():
            if target in path:
                circle = " -> ".join([*path[path.index(target):], target])
                errors.append(f"{source / name}:{line}: include cycle: {circle}")
            elif target not in done:
                visit(target, [*path, target])
        done.add(name)

    for name in graph:
        if name not in done:
            visit(name, [name])
    return errors


def main():
    root = pathlib.Path(__file__).resolve().parent.parent
    source = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "src"
    errors = check(source)
    print("\n".join(errors) if errors else f"{source}: includes run downward only")
    sys.exit(1 if errors else 0)


if __name__ == "__main__":
    main()
