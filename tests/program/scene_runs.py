#!/usr/bin/python3
"""Runs random scenes of bodies that hit one another, and checks what comes out without the program's own code.

  tests/program/scene_runs.py 1-100 --jobs 2 --keep /tmp/scenes      # a line for each seed, and the sums
  tests/program/scene_runs.py 17 --keep /tmp/scenes                  # again, with its files

A seed passes if the run ends well and in time, all of its numbers are finite, it has a frame for each accepted step, no surface passes
another in any frame, the books balance, free bodies keep their momentum, and nothing is gained from nothing.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import pathlib
import shutil
import sys
import tempfile
import time

import h5py
import numpy as np

from overlaps import overlaps
from program import UNSIGNALLED, finish, read_history, start
from scenes import write_scene

TIME_LIMIT = 600  # [s]; far above what a scene takes on an idle machine
LARGEST_IMBALANCE = 1e-5  # of the energy
ROUNDING = 1e-12  # of the energy at a strain of 1, which bodies may store that nothing strains
LARGEST_GAIN = 0.1  # of the energy that was there or supplied; of methods that damp what they do not resolve
LARGEST_IMPULSE = 1e-6  # on free bodies, of the sum of all momenta
DAMPING_METHODS = ("backward-euler", "bdf2", "dirk22", "dirk33")


@dataclasses.dataclass
class Outcome:
    """What became of a seed."""

    seed: int
    scene: str
    problems: list
    accepted: int = 0
    halved: int = 0
    shortest: float = 1.0  # step, relative to the nominal one
    least_gap: float = np.inf
    gain: float = 0.0
    imbalance: float = 0.0
    seconds: float = 0.0


def check_frames(scene, directory, history):
    """Problems of result.h5."""
    problems = []
    with h5py.File(directory / "result.h5") as file:
        frames = file["frames"]
        steps = sorted(int(frame.attrs["step"]) for frame in frames.values())
        if steps != history["step"].astype(int).tolist():
            problems.append(f"{len(steps)} frames for {len(history['step'])} rows")
        for name, frame in frames.items():
            for field, values in frame.items():
                if not np.isfinite(values[:]).all():
                    problems.append(f"{field} of frame {name} is not finite")
        problems += beyond_obstacle(scene, file)
    found = overlaps(directory / "result.h5", scene.touching)
    if found:
        problems.append(f"{len(found)} intersections, the first in frame {found[0].frame}: {found[0].what} "
                        f"(bodies {found[0].body}, {found[0].other})")
    return problems


def beyond_obstacle(scene, file):
    """Nodes that an obstacle should have kept out."""
    if scene.obstacle is None:
        return []
    rest, problems = file["mesh/coordinates"][:], []
    point = np.array(scene.obstacle["point"])
    rise = scene.obstacle.get("motion", {"translate": [0, 0, "0*t"]})["translate"][2]
    for name, frame in file["frames"].items():
        x = rest + frame["displacement"][:] - point
        if scene.obstacle["shape"] == "plane":
            gap = x[:, 2].min() - float(rise.removesuffix("*t")) * frame.attrs["time"]
        else:
            gap = scene.obstacle["radius"] - np.linalg.norm(x, axis=1).max()
        if not gap > 0:
            problems.append(f"a node is beyond the obstacle in frame {name}, by {-gap:.3g} m")
    return problems[:1]


def check_history(scene, history, outcome):
    problems = [f"{name} is not finite" for name, values in history.items()
                if name != "contact_gap_min" and not np.isfinite(values).all()]
    energy = history["kinetic_energy"] + history["elastic_energy"]
    supplied = np.maximum.accumulate(energy + np.abs(history["load_work"]) + np.abs(history["load_potential"] - history["load_potential"][0]))
    scale = max(supplied.max(), ROUNDING * scene.strain_energy)
    outcome.imbalance = np.abs(history["energy_balance_error"]).max() / scale
    outcome.gain = max(0.0, -history["numerical_dissipation"].min() / scale)
    if outcome.imbalance > LARGEST_IMBALANCE:
        problems.append(f"the energy balance is off by {outcome.imbalance:.2g}")
    if scene.method in DAMPING_METHODS and outcome.gain > LARGEST_GAIN:
        problems.append(f"the method gains {outcome.gain:.2g} of the energy")
    if scene.is_free:
        momentum = np.stack([history[f"p{axis}"] for axis in "xyz"])
        scale = 2 * history["kinetic_energy"][0] / scene.speed
        if np.abs(momentum - momentum[:, :1]).max() > LARGEST_IMPULSE * scale:
            problems.append(f"momentum changes by {np.abs(momentum - momentum[:, :1]).max() / scale:.2g}")
    return problems


def run_scene(seed, directory, ranks=None, time_limit=TIME_LIMIT):
    """Writes, runs and checks a scene in an empty directory; on `ranks`, or as many as the scene says."""
    scene = write_scene(seed, directory)
    scene.ranks = ranks or scene.ranks
    outcome = Outcome(seed, f"{len(scene.names)} bodies, {scene.element}, {scene.method}, {scene.step * 1e3:.1f} ms x {scene.num_steps}, "
                      f"{scene.ranks} ranks", [])
    begin = time.monotonic()
    try:
        done = finish(start(["run", scene.input, "--quiet", "--output", "out"], directory, scene.ranks, UNSIGNALLED), time_limit)
    except AssertionError:
        outcome.seconds = time.monotonic() - begin
        outcome.problems.append("hangs")
        return outcome
    outcome.seconds = time.monotonic() - begin
    (directory / "log").write_text(done.stdout + done.stderr, encoding="utf-8")
    check_run(scene, directory, done, outcome)
    return outcome


def check_run(scene, directory, done, outcome):
    """Adds to an outcome what a completed process left."""
    if scene.is_refused:
        if done.returncode != 2 or "stiffly accurate" not in done.stderr:
            outcome.problems.append(f"the method is not refused (exit code {done.returncode})")
        return
    if done.returncode != 0:
        reason = next((line for line in done.stderr.splitlines()[::-1] if "error" in line), done.stderr[-300:])
        outcome.problems.append(f"exit code {done.returncode}: {reason}")
    if not (directory / "out/history.csv").exists():
        return
    history = read_history(directory / "out")
    outcome.accepted = len(history["step"]) - 1
    if outcome.accepted > 0:
        outcome.shortest = history["dt"][1:].min() / scene.step
        outcome.least_gap = history["contact_gap_min"].min()
    summary = directory / "out/summary.json"
    if summary.exists():
        outcome.halved = json.loads(summary.read_text())["steps"]["failed"]
    outcome.problems += check_history(scene, history, outcome) + check_frames(scene, directory / "out", history)


def run_kept(seed, options):
    """In a directory of the seed under options.keep, or one that is removed."""
    if options.keep is None:
        with tempfile.TemporaryDirectory(prefix="pliant-scene-") as directory:
            return run_scene(seed, pathlib.Path(directory), options.ranks, options.time_limit)
    directory = options.keep / str(seed)
    shutil.rmtree(directory, ignore_errors=True)
    directory.mkdir(parents=True)
    return run_scene(seed, directory, options.ranks, options.time_limit)


def seeds_of(text):
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("seeds", nargs="+", type=seeds_of, help="a seed, or the first and last of some: 1-100")
    parser.add_argument("--jobs", type=int, default=1, help="scenes at a time")
    parser.add_argument("--ranks", type=int, help="ranks of all scenes; default: each has its own number")
    parser.add_argument("--time-limit", type=float, default=TIME_LIMIT, help="of a scene [s]; default: %(default)s")
    parser.add_argument("--keep", type=pathlib.Path, help="where the files of each seed stay; default: they are removed")
    options = parser.parse_args()
    outcomes = []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = [pool.submit(run_kept, seed, options) for seeds in options.seeds for seed in seeds]
        for run in concurrent.futures.as_completed(runs):
            outcome = run.result()
            outcomes.append(outcome)
            print(f"{outcome.seed:5d} {outcome.seconds:6.1f} s  {outcome.accepted:5d} steps {outcome.halved:4d} halved, shortest "
                  f"{outcome.shortest:8.2g}  gap {outcome.least_gap:8.2g}  gain {outcome.gain:7.1g}  imbalance {outcome.imbalance:7.1g}  "
                  f"{outcome.scene}  {'; '.join(outcome.problems) or 'ok'}", flush=True)
    wrong = [outcome for outcome in outcomes if outcome.problems]
    print(f"{len(outcomes)} scenes: {len(wrong)} with problems; {sum(o.accepted for o in outcomes)} steps, "
          f"{sum(o.halved for o in outcomes)} halved, at most {max(o.halved for o in outcomes)} in a scene; "
          f"{sum(o.seconds for o in outcomes):.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
