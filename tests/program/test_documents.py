"""What the documents show works: their commands run, at a small size, and their inputs and parts of inputs are taken.

A block marked `sh` is a script: it runs in a folder that looks like a clone, where `build/bin/pliant` and `pliant` are the
program with a short run, a coarse mesh and a small picture, and `mpirun -n N` starts one rank, or at most two with PLIANT_LONG_TESTS. A command that stands
on several pages runs once. A block marked `yaml` is an input or goes into a small one, which `pliant check` must find well; or it is a fit, which `pliant fit`
must bring to an end.
"""
import itertools
import json
import os
import pathlib
import re
import shutil
import subprocess
import unittest

import numpy as np
import yaml

from program import ENVIRONMENT, LONG, PROGRAM, ROOT, ProgramTest, box, write_cube
from test_inputs import SMALL

BLOCK = re.compile(r"^( *)```(\w+)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)

# Beginnings of commands that do not run here, and why.
SKIPPED = {
    "tools/run.sh": "sets up and builds",
    "tools/test.sh": "would start this test again",
    "tools/setup.sh packages": "needs root",
    "tools/docs.sh": "is a test of its own",
    "apt-get ": "needs root",
    "cmake ": "builds; what is installed and built on that is tested in tests/package",
    "cpack ": "likewise",
    "PKG_CONFIG_PATH=": "needs another PETSc, and builds",
    "~/pliant/bin/pliant": "tested in tests/package",
    "trapped/trapped": "likewise",
    "tools/fuzz.sh": "takes as long as it is told",
    "tools/sanitize.sh": "builds everything anew",
    "PLIANT_LONG_TESTS=1": "takes an hour",
}
# What is run in place of a command.
SHORTENED = {"docs/examples/damper.py": "docs/examples/damper.py 10"}  # one of four frequencies
# Pages whose commands stand on earlier runs.
BEFORE = {
    "docs/output.md": "build/bin/pliant run input/cantilever.yaml",
    "docs/paraview.md": "build/bin/pliant run input/cantilever.yaml",
    "docs/report.md": "build/bin/pliant run input/gripper_finger.yaml",
    "docs/restart.md": "pliant run beam.yaml",
}
# Pages that explain one input: what they show stands in it.
EXPLAINED = {"docs/tendon-gripper.md": "input/tendon_gripper.yaml"}
INPUT = """
mesh: {file: body.msh}
bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]
constraints: [{surface: clamp, displacement: [0, 0, 0]}]
loads: [{gravity: [0, 0, -9.81]}]
"""
SHIM = """#!/usr/bin/python3
import json, os, re, sys
arguments = sys.argv[1:]
end = arguments.index("--") if "--" in arguments else len(arguments)
own, petsc = arguments[:end], arguments[end:]
small = json.load(open(os.environ["SMALL"]))
settings = ["time.end=0.42"] if own[0] == "resume" and "--set" in own else []
if own[0] in ("run", "check", "converge", "sweep"):
    settings = small[os.path.basename(own[1])]
    if own[0] == "sweep":  # the first two values of a list
        own = [re.sub(r"=\\[([^][,]*,[^][,]*),[^][]*\\]$", r"=[\\1]", word) for word in own]
        own = ["2" if before == "--samples" else word for before, word in zip([""] + own, own)]
    if own[0] == "converge":
        own.append("--no-check") if "--no-check" not in own else None
        own[own.index("--levels") + 1] = "2"
        own = [word.replace("all", "bdf2,dirk22") if before == "--methods" else word for before, word in zip([""] + own, own)]
if own[0] == "render" and "--size" not in own and not any(word.endswith(".glb") for word in own):
    own += ["--size", "480x360"]
for setting in settings:
    key = setting.split("=")[0] + "="
    place = [k for k, word in enumerate(own) if word.startswith(key)]
    if place and "[" in own[place[0]]:
        continue  # a list of a sweep
    if place:
        own[place[0]] = setting
    else:
        own += ["--set", setting]
os.execv(os.environ["PROGRAM"], ["pliant", *own, *petsc])
"""
MPIRUN = """#!/bin/sh
[ "$1" = -n ] || exit 99
ranks=$2; [ "$ranks" -le 2 ] || ranks=2
shift 2
[ "$PLIANT_LONG_TESTS" ] || exec "$@"
exec "$MPIRUN" --quiet --oversubscribe --bind-to none -n "$ranks" "$@"
"""


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]


def blocks(language):
    """(page, line, text) of each block of the language."""
    for page in pages():
        text = page.read_text(encoding="utf-8")
        for match in BLOCK.finditer(text):
            if match[2] == language:
                yield page.relative_to(ROOT).as_posix(), text.count("\n", 0, match.start()) + 1, match[3]


def what_runs(command):
    """A command without its comment and the number of ranks."""
    plain = re.sub(r"\s+# .*$", "", command)
    return plain if LONG else re.sub(r"^(mpirun -n \d+ )?(build/bin/)?(?=pliant )", "", plain)


def is_run_as_typed(fit):
    """Is it a file in input/fit that a command of the documents fits?"""
    for file in (ROOT / "input/fit").glob("*.yaml"):
        if yaml.safe_load(file.read_text(encoding="utf-8")) == fit:
            return any(f"pliant fit input/fit/{file.name}" in text for _, _, text in blocks("sh"))
    return False


def small_settings():
    """What makes each shipped input small; of studies two steps."""
    settings = {"beam.yaml": [], "input.yaml": [], **SMALL,
                "dropped_club.yaml": ["mesh.size=0.02", "time.end=0.02"],
                "cantilever.yaml": ["mesh.size=0.2", "element=P1", "time.end=0.03"],
                "gripper.yaml": ["time.step=20 ms", "time.end=0.04", "time.events=[]"],
                "tendon_gripper.yaml": ["mesh.size=6 mm", "time.step=20 ms", "time.end=0.04", "time.events=[]"]}
    for file in (ROOT / "input/convergence").glob("*.yaml"):
        time = yaml.safe_load(file.read_text(encoding="utf-8"))["time"]
        if time.get("method") == "static":
            settings[file.name] = []
        elif "adaptive" in time:
            settings[file.name] = ["time.end=0.02"]
        else:
            number, _, unit = str(time["step"]).partition(" ")
            settings[file.name] = [f"time.end={2 * float(number)}" + (f" {unit}" if unit else "")]
    return settings


def write_measurements(directory):
    """Tables for the fits that the documents show: Treloar's, and made ones of viscosity."""
    for file in (ROOT / "input/data").glob("*.csv"):
        shutil.copy(file, directory)
    time = np.geomspace(1.2, 60, 30)  # held since 1 s
    relaxing = np.column_stack([time, 2e5 * (1 + 0.5 * np.exp(-time / 2) + 0.8 * np.exp(-time / 15))])
    np.savetxt(directory / "held.csv", relaxing, delimiter=",", header="time,stress", comments="")
    w = np.geomspace(0.1, 1e4, 30)
    modulus = 1e5 * (1 + sum(0.3 * 1j * w * tau / (1 + 1j * w * tau) for tau in (1e-3, 1e-2, 1e-1, 1)))
    np.savetxt(directory / "sweep.csv", np.column_stack([w, modulus.real, modulus.imag]), delimiter=",",
               header="angular_frequency,storage_modulus,loss_modulus", comments="")


class UniqueKeys(yaml.SafeLoader):
    """Two keys of one name are a mistake, as in Pliant."""

    def construct_mapping(self, node, deep=False):
        keys = [self.construct_object(key) for key, _ in node.value]
        assert len(keys) == len(set(keys)), f"a key is there twice: {keys}"
        return super().construct_mapping(node, deep)


def write_body(path, names):
    """A box whose volumes, sides and one corner have names: {"volume": [...], "surface": [...], ...}, with data of cells."""
    count = max(1, len(names["volume"]))
    points, sides, cells = box((2 * count, 2, 2))
    middle = points[cells].mean(axis=1)[:, 0]
    volume_of_cell = np.minimum((middle * count).astype(int), count - 1)
    standard = ["left", "right", "front", "back", "bottom", "top"]
    others = iter([n for n in names["surface"] if n not in standard])
    surfaces = [side if side in names["surface"] else next(others, side) for side in standard]
    groups = [f'3 {k + 1} "{name}"' for k, name in enumerate(names["volume"] or ["body"])]
    groups += [f'2 {k + 11} "{name}"' for k, name in enumerate(surfaces)]
    groups += [f'0 {k + 21} "{name}"' for k, name in enumerate(names["point"])]
    elements = [f"15 2 {k + 21} 1 1" for k in range(len(names["point"]))]
    for k, side in enumerate(sides):
        elements += [f"2 2 {k + 11} 1 " + " ".join(map(str, t + 1)) for t in side]
    first_cell = len(elements) + 1
    elements += [f"4 2 {v + 1} 1 " + " ".join(map(str, c + 1)) for v, c in zip(volume_of_cell, cells)]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", len(groups), *groups, "$EndPhysicalNames",
            "$Nodes", len(points), *(f"{n + 1} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(points.tolist())),
            "$EndNodes", "$Elements", len(elements), *(f"{n + 1} {e}" for n, e in enumerate(elements)), "$EndElements"]
    for name, values in (("stiffness", "2e6"), ("sheets", "0 0 1")):
        text += ["$ElementData", 1, f'"{name}"', 1, 0.0, 3, 0, len(values.split()), len(cells),
                 *(f"{first_cell + n} {values}" for n in range(len(cells))), "$EndElementData"]
    path.write_text("\n".join(map(str, text)) + "\n", encoding="ascii")


def names_in(tree, names):
    if isinstance(tree, list):
        for entry in tree:
            names_in(entry, names)
    elif isinstance(tree, dict):
        for key, value in tree.items():
            kind = "surface" if key in ("periodic_with", "tied_to", "with", "in") else key
            if key in ("attached", "coupled"):
                names_in([{"surface": name} for name in value], names)
            if key == "exclude":
                names_in([{"surface": name} for pair in value for name in pair], names)
            if kind in names and isinstance(value, str):
                names[kind].append(value) if value not in names[kind] else None
            names_in(value, names)
    return names


def completed(part):
    """A part of an input, in an input."""
    base = {"mesh": {"file": "body.msh"}, "time": {"method": "bdf2", "step": 0.01, "end": 1},
            "bodies": [{"elasticity": {"model": "neo-hookean", "youngs_modulus": 1e6, "poissons_ratio": 0.4}}]}
    if "cavities" in part:
        base = yaml.safe_load((ROOT / "input/gripper_finger.yaml").read_text(encoding="utf-8"))
        base["mesh"]["file"] = str(ROOT / "meshes/gripper_finger.geo")
    for key, value in part.items():
        if key in ("elasticity", "viscosity", "active"):
            base["bodies"][0][key] = value
        else:
            base[key] = value
    for body in base["bodies"]:
        body.setdefault("density", 1000)
    return base


class Documents(ProgramTest):
    def make_clone(self):
        for name in ("input", "meshes", "tools", "src", "tests"):
            (self.directory / name).symlink_to(ROOT / name)
        (self.directory / "docs").mkdir()
        (self.directory / "docs/examples").symlink_to(ROOT / "docs/examples")
        (self.directory / "build/bin").mkdir(parents=True)
        for path, text in (("build/bin/pliant", SHIM), ("bin/pliant", SHIM), ("bin/mpirun", MPIRUN)):
            file = self.directory / path
            file.parent.mkdir(exist_ok=True)
            file.write_text(text, encoding="utf-8")
            file.chmod(0o755)
        (self.directory / "small.json").write_text(json.dumps(small_settings()), encoding="utf-8")
        write_body(self.directory / "body.msh", {"volume": [], "surface": ["clamp"], "point": []})
        time = "time: {method: backward-euler, step: 1 ms, end: 0.4}\noutput: {directory: out/beam, every: 0.1}\n"
        self.write("beam.yaml", INPUT + time + "checkpoint: {every: 100}\n")
        self.write("input.yaml", INPUT + "time: {method: bdf2, step: 1 ms, end: 2 ms}\n")
        mpirun = subprocess.run(["which", "mpirun"], capture_output=True, text=True, check=True).stdout.strip()
        return {**ENVIRONMENT, "PATH": f"{self.directory}/bin:{os.environ['PATH']}", "PROGRAM": str(PROGRAM),
                "SMALL": str(self.directory / "small.json"), "MPIRUN": mpirun, "HOME": str(self.directory),
                "XDG_CACHE_HOME": str(self.directory / "cache")}  # several commands have one mesh

    def test_commands_run(self):
        environment = self.make_clone()
        done_before = set()
        for page, of_page in itertools.groupby(blocks("sh"), key=lambda block: block[0]):
            scripts = [(0, BEFORE[page])] if page in BEFORE else []
            for _, line, text in of_page:
                subprocess.run(["bash", "-n"], input=text, text=True, check=True)
                if "#SBATCH" in text:
                    continue  # needs a cluster
                scripts.append((line, text))
            for line, text in scripts:
                commands = [c for c in text.splitlines() if not c.startswith(tuple(SKIPPED)) and what_runs(c) not in done_before]
                done_before.update(what_runs(c) for c in commands if not c.startswith("export"))
                script = "\n".join(commands)
                for full, short in SHORTENED.items():
                    script = script.replace(full, short)
                if not script:
                    continue
                with self.subTest(f"{page}:{line}"):
                    done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=self.directory, env=environment, text=True,
                                          stdin=subprocess.DEVNULL, capture_output=True, check=False, timeout=300)
                    self.assertEqual(done.returncode, 0, f"{script}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")

    def test_inputs_are_taken(self):
        (self.directory / "input").mkdir()
        (self.directory / "meshes").symlink_to(ROOT / "meshes")
        (self.directory / "docs").symlink_to(ROOT / "docs")
        write_cube(self.directory / "fruit.stl", (0, 0, 100), (20, 20, 120))
        write_cube(self.directory / "needle.stl", (0, 0, -30), (1, 1, -10))
        for page, line, text in blocks("yaml"):
            part = yaml.load(text, UniqueKeys)
            if part is None:
                continue  # a comment
            with self.subTest(f"{page}:{line}"):
                if page in EXPLAINED:
                    whole = yaml.safe_load((ROOT / EXPLAINED[page]).read_text(encoding="utf-8"))
                    for key, value in part.items():
                        for entry in value if isinstance(value, list) else [value]:
                            self.assertIn(entry, whole[key] if isinstance(value, list) else [whole[key]])
                    continue
                if is_run_as_typed(part):
                    continue
                if {"input", "targets"} <= set(part):
                    text = text.replace("../released", f"{ROOT}/input/released").replace("../data", f"{ROOT}/input/data")
                    done = self.call("fit", self.write("motion.yaml", text))
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    continue
                if {"material", "tests"} <= set(part):
                    (self.directory / "fit").mkdir(exist_ok=True)
                    write_measurements(self.directory / "fit")
                    (self.directory / "data").is_symlink() or (self.directory / "data").symlink_to(ROOT / "input/data")
                    done = self.call("fit", self.write("fit/fit.yaml", text))
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
                    continue
                needs_no_body = any(shell.get("free") for shell in part.get("shells", []))
                are_rods_alone = {"rods", "time"} <= set(part) and not {"mesh", "bodies"} & set(part) and all("points" in r for r in part["rods"])
                if {"mesh", "bodies", "time"} <= set(part) | ({"bodies"} if needs_no_body else set()) or are_rods_alone:
                    file = self.write("input/whole.yaml", text)
                else:
                    names = names_in(part, {"volume": [], "surface": [], "point": []})
                    names["volume"] = [name for name in names["volume"]
                                       if name not in [body["name"] for body in part.get("rigid_bodies", [])]]
                    write_body(self.directory / "body.msh", names)
                    file = self.write("part.yaml", yaml.safe_dump(completed(part)))
                done = self.call("check", file)
                self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    unittest.main()
