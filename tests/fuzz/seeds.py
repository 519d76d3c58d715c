#!/usr/bin/python3
"""Writes the seeds of the fuzzers into tests/fuzz/corpus: small whole files of each kind, which fuzzing starts from.

What fuzzing found lies beside them, named after what was wrong.
"""
import pathlib
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "mesh"))

from other_formats import Body, abaqus, medit, nastran, unv, vtk, vtu, write_med  # noqa: E402
from bricks import Brick, write_parts  # noqa: E402

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"
BODY = "elasticity: {model: neo-hookean, youngs_modulus: 1 MPa, poissons_ratio: 0.4}"
INPUTS = {
    "plain": f"""title: plain
mesh: {{file: a.msh, scale: 0.001, refine: 1}}
bodies: [{{density: 1 g/cm^3, {BODY}}}]
constraints: [{{surface: left, displacement: [0, free, "0.1*sin(2*pi*t)"]}}]
loads: [{{gravity: [0, 0, -9.81]}}, {{surface: top, traction: [0, 0, 1 kPa]}}, {{surface: 3, pressure: 2*t}}]
time: {{method: bdf2, step: 5 ms, end: 1 s, startup: ramp, events: [0.1, 0.5 s]}}
output: {{directory: out, every: 20 ms, fields: [displacement, velocity], history: [{{name: peak, of: cauchy_stress_xx, in: beam, take: max}}]}}
probes: [{{name: tip, point: [1, 0, 1 mm]}}]
checkpoint: {{every: 10}}
""",
    "rich": """mesh: {file: a.geo, size: 2 cm}
element: P2
mass: lumped
bodies:
  - volume: one
    density: 1000
    elasticity: &law {model: mooney-rivlin, c10: 1 kPa, c01: 1 kPa, bulk_modulus: 1 MPa}
    viscosity: [{model: kelvin-voigt, shear: 20 Pa*s, bulk: 1}, {model: maxwell, shear_modulus: 1 kPa, relaxation_time: 1 ms}]
  - volume: three
    density: 900
    elasticity: *law
    expansion: {stretch: "1 + 0.01*min(t, x)"}
    mullins: {r: 2.1, m: 20 kPa, beta: 0.1}
  - volume: four
    elasticity: {library: ecoflex-00-30, poissons_ratio: 0.49, incompressible: false}
  - volume: two
    density: 900
    elasticity: {model: linear, youngs_modulus: {cell_data: stiffness}, poissons_ratio: 0.1*x}
constraints:
  - {box: [[0, 0, 0], [1, 1, 1]], symmetry: plane}
  - {where: "x < 1e-9 && abs(y) > 1", normal_displacement: 0}
  - {surface: a, rigid: {rotation: {axis: [0, 0, 1], angle: 90 degree}}}
loads: [{surface: a, spring: 1, direction: normal}, {point: p, force: [0, 0, 1 N]}]
cavities: [{name: c, surface: inside, gas: {}}]
time: {end: 1, adaptive: {relative: 1e-4, absolute: 1 um}}
solver: {linear: amg, newton: {relative: 1e-6}}
""",
    "static": f"""mesh: {{file: a.h5}}
bodies: [{{{BODY}}}]
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
time: {{method: static}}
""",
    "rods": """rods:
  - {name: wire, points: [[0, 0, 0], [1, 0, 0]], size: 5 cm, radius: 1 mm, density: 7800, youngs_modulus: 200 GPa, poissons_ratio: 0.3,
     start: ground}
  - {name: strip, points: [[0, 0, 0], [0, 1, 0], [0, 1, 1]], segments: 3, section: {width: 1 cm, height: 1 mm, up: [1, 0, 0]},
     density: 1000, youngs_modulus: 1 MPa, poissons_ratio: 0.5, end: tip}
rigid_bodies: [{name: tip, center: [0, 1, 1]}]
time: {method: bdf2, step: 5 ms, end: 1 s}
""",
    "shells": f"""mesh: {{file: a.h5}}
bodies: [{{{BODY}}}]
shells:
  - {{name: skin, surface: outside, thickness: 1 mm, density: 1000, prestretch: 1.1, damping: 1 ms,
     elasticity: {{model: mooney-rivlin, c10: 0.3 MPa, c01: 80 kPa, bulk_modulus: 1 GPa}}}}
  - {{name: foil, where: "z < 0.1", thickness: 0.1 mm, prestretch: [1.1, 1], direction: [1, 0, 0], bending: true,
     elasticity: {{model: linear, youngs_modulus: 1 GPa, poissons_ratio: 0.3}}}}
constraints: [{{surface: left, displacement: [0, 0, 0]}}]
time: {{method: static}}
""",
    "tableau": f"""mesh:
  file: 'a.msh'
bodies:
- density: 1e3
  {BODY}
time: {{method: {{A: [[1/4, 0], [1/2, 1/4]], b: [1/2, 1/2], name: own}}, step: 0.01, end: 1}}
""",
}

FITS = {
    "material": """title: rubber
material: {model: ogden, terms: 2, incompressible: true, alpha1: 1.3, volumetric: log}
residual: relative
bounds: {mu1: [0, 1 MPa], alpha2: [-5, 5]}
initial: {mu1: 0.3 MPa}
tests:
  - {kind: uniaxial, data: a.csv, weight: 2}
  - {kind: pure-shear, data: b.csv}
starts: 20
""",
    "viscous": """material: {model: neo-hookean, poissons_ratio: 0.45}
viscosity: {model: prony, relaxation_times: [1 ms, 0.1 s]}
tests:
  - {kind: relaxation, data: held.csv, stretch: 1.5, rate: 0.5 Hz}
  - {kind: relaxation, data: sheared.csv, loading: simple-shear, shear: 0.3}
  - {kind: dma, data: sweep.csv, loading: simple-shear}
  - {kind: volumetric, data: pressed.csv}
""",
    "motion": """input: beam.yaml
parameters:
  bodies.0.elasticity.youngs_modulus: [0.1 MPa, 10 MPa]
  contact.friction: [0, 1]
targets:
  - {column: tip_z, data: tip.csv, scale: 1 mm}
  - {column: clamp_fx, data: force.csv, weight: 0.5}
starts: 3
""",
}


def small(brick):
    """Eight corners and six cells of it."""
    corners = [1, 2, 4, 5, 10, 11, 13, 14]
    brick.points = [brick.points[n - 1] for n in corners]
    brick.tags = list(corners)
    brick.blocks = [(*block[:4], [m for m in block[4] if set(m) <= set(corners)]) for block in brick.blocks]
    brick.blocks = [block for block in brick.blocks if block[4]]
    return brick


def element_data(brick):
    rows = [f"{n + 1 + brick.num_elements() - len(brick.cells())} {n}.5" for n in range(len(brick.cells()))]
    return "\n".join(["$ElementData", "1", '"stiffness"', "1", "0.0", "3", "0", "1", str(len(rows)), *rows, "$EndElementData", ""])


def write_other_formats():
    """Twelve cells, of first and second order, in the formats of other programs."""
    first, second = (Body(order, (2, 1, 1)) for order in (1, 2))
    seeds = {"abaqus/plain.inp": abaqus(first), "abaqus/parts.inp": abaqus(first, parts=True), "abaqus/second_order.inp": abaqus(second),
             "nastran/free.bdf": nastran(first), "nastran/large.bdf": nastran(first, "large"), "nastran/second_order.bdf": nastran(second),
             "medit/first_order.mesh": medit(first), "medit/second_order.mesh": medit(second), "medit/cut.mesh": medit(first)[:500],
             "unv/first_order.unv": unv(first), "unv/second_order.unv": unv(second), "unv/cut.unv": unv(first)[:2500],
             "vtk/text.vtk": vtk(first), "vtk/bytes.vtk": vtk(first, binary=True), "vtk/second_order.vtk": vtk(second, version="5.1"),
             "vtu/text.vtu": vtu(first), "vtu/packed.vtu": vtu(first, "zlib"), "vtu/second_order.vtu": vtu(second, "raw zlib", "UInt64")}
    for name, content in seeds.items():
        (CORPUS / name).parent.mkdir(parents=True, exist_ok=True)
        (CORPUS / name).write_bytes(content)
    (CORPUS / "med").mkdir(exist_ok=True)
    write_med(first, CORPUS / "med/first_order.med")
    write_med(second, CORPUS / "med/second_order.med")
    whole = (CORPUS / "med/first_order.med").read_bytes()
    (CORPUS / "med/cut.med").write_bytes(whole[: len(whole) // 2])


def write_checkpoint(path):
    with h5py.File(path, "w", userblock_size=512) as file:
        texts = {"title": "a run", "mesh": "0123", "program": "pliant 0", "petsc_options": "-a"}
        file.attrs.update({"step": 12, "time": 0.25, "ranks": 3, **{name: np.bytes_(text) for name, text in texts.items()}})
        file["input"] = np.bytes_("mesh: {file: a.msh}\n")
        state = file.create_group("state")
        state.attrs.update({"number": [0.5], "numbers": [1.0, 2.0, 3.0]})
        state["q"] = np.arange(12.0).reshape(4, 3)
        state["p"] = np.arange(4.0)
    with open(path, "r+b") as file:
        file.write(b"pliant-checkpoint\nversion 1\n")


TRIANGLES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))  # of a tetrahedron
CORNERS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))


def write_surfaces(folder):
    facets = "".join("facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*CORNERS[c]) for c in triangle) +
                     "endloop\nendfacet\n" for triangle in TRIANGLES)
    (folder / "text.stl").write_text(f"solid a\n{facets}endsolid a\n")
    (folder / "open.stl").write_text(f"solid a\n{facets[: len(facets) // 2]}endsolid a\n")
    (folder / "bytes.stl").write_bytes(binary_stl(TRIANGLES, CORNERS))


def write_triangles(folder):
    (folder / "tetrahedron.stl").write_bytes(binary_stl(TRIANGLES, CORNERS))
    (folder / "inwards.stl").write_bytes(binary_stl([t[::-1] for t in TRIANGLES], CORNERS))
    # One of them has no area: its corners lie on an edge.
    (folder / "without_area.stl").write_bytes(binary_stl([*TRIANGLES[:3], (2, 4, 3), (2, 0, 4), (4, 0, 3)], [*CORNERS, (0, 0, 0.5)]))
    (folder / "open.stl").write_bytes(binary_stl(TRIANGLES[:3], CORNERS))


def binary_stl(triangles, corners):
    facets = [np.array([[0, 0, 0], *(corners[c] for c in triangle)], "<f4").tobytes() + b"\0\0" for triangle in triangles]
    return b"bytes".ljust(80) + len(facets).to_bytes(4, "little") + b"".join(facets)


def write_result(path):
    with h5py.File(path, "w", libver=("earliest", "v110")) as file:
        file.attrs.update({"format": np.bytes_("pliant-result"), "version": 1, "title": np.bytes_("a run")})
        file["mesh/coordinates"] = np.array(CORNERS, float)
        file["mesh/cells"] = np.arange(4).reshape(1, 4)
        for step in range(2):
            frame = file.create_group(f"frames/{step:06}")
            frame.attrs.update({"time": 0.5 * step, "step": step, "mesh": np.bytes_("/mesh")})
            frame["u"] = np.ones((4, 3))
            frame["u"].attrs.update({"unit": np.bytes_("m"), "location": np.bytes_("node")})


def main():
    for name in ("input", "fit", "msh", "mesh_file", "surface", "triangles", "result", "checkpoint"):
        (CORPUS / name).mkdir(parents=True, exist_ok=True)
    for name, text in INPUTS.items():
        (CORPUS / "input" / f"{name}.yaml").write_text(text)
    for name, text in FITS.items():
        (CORPUS / "fit" / f"{name}.yaml").write_text(text)
    for name, content in {"text2": small(Brick()).msh2() + element_data(small(Brick())).encode(), "text4": small(Brick()).msh4(),
                          "bytes2": small(Brick()).msh2(binary=True), "bytes4": small(Brick()).msh4(binary=True, order=">")}.items():
        (CORPUS / "msh" / f"{name}.msh").write_bytes(content)
    write_other_formats()
    write_parts(CORPUS / "mesh_file" / "three_cells.h5")
    write_parts(CORPUS / "mesh_file" / "data.h5", with_data)
    write_parts(CORPUS / "mesh_file" / "packed.h5", packed)
    write_surfaces(CORPUS / "surface")
    write_triangles(CORPUS / "triangles")
    write_result(CORPUS / "result" / "two_frames.h5")
    whole = (CORPUS / "result" / "two_frames.h5").read_bytes()
    (CORPUS / "result" / "cut.h5").write_bytes(whole[: len(whole) // 2])
    (CORPUS / "result" / "text.h5").write_bytes(b"pliant-result")
    write_checkpoint(CORPUS / "checkpoint" / "whole.h5")
    whole = (CORPUS / "checkpoint" / "whole.h5").read_bytes()
    (CORPUS / "checkpoint" / "header_alone.h5").write_bytes(b"pliant-checkpoint\nversion 1\nbytes 60\ncrc32 00000000\n".ljust(60, b"\0"))
    (CORPUS / "checkpoint" / "cut.h5").write_bytes(whole[: len(whole) // 2])


def with_data(file):
    file["cell_data/0"] = np.ones((3, 1))
    file["cell_data/0"].attrs["name"] = np.bytes_("stiffness")


def packed(file):
    nodes = file["nodes"][:]
    del file["nodes"]
    file.create_dataset("nodes", data=nodes, chunks=True, compression="gzip")


if __name__ == "__main__":
    main()
