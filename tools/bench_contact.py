#!/usr/bin/python3
"""Contact between two bodies in Pliant, CalculiX and GetFEM, side by side: seconds per step, and what each says of the contact.

  tools/bench_contact.py                      every case, one rank and two (needs Debian's calculix-ccx and python3-getfem)
  tools/bench_contact.py patch --ranks 2      one of them

Same mesh, elastic constants, constraints and steps, one program after the other; let nothing else run meanwhile. CalculiX
factorizes with SPOOLES, on as many threads as Pliant has ranks, and has contact by a penalty, face to face. GetFEM factorizes
with sequential MUMPS, and has contact by the same penalty, integrated over the upper face; it does the static cases on one rank.
"""
import os
import re
import subprocess
import sys
import tempfile
import time

import meshio
import numpy as np

import package  # noqa: F401  finds the package pliant
from pliant.command_line import Parser, report

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PLIANT = os.environ.get("PLIANT", os.path.join(ROOT, "build", "bin", "pliant"))
# Faces of a tetrahedron in the order of CalculiX, by its corners.
FACES = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]

GEOMETRY = """SetFactory("OpenCASCADE");
Box(1) = {0, 0, 0, 1, 1, 1};
Box(2) = {%(inset)s, %(inset)s, 1 + %(gap)s, 1 - 2*%(inset)s, 1 - 2*%(inset)s, 1};
MeshSize{ PointsOf{ Volume{1}; } } = %(coarse)s;
MeshSize{ PointsOf{ Volume{2}; } } = %(fine)s;
Mesh.MeshSizeExtendFromBoundary = 1;
Mesh.ElementOrder = %(order)s;
Physical Volume("lower") = {1};
Physical Volume("upper") = {2};
Physical Surface("bottom") = {5};
Physical Surface("lid") = {12};
Physical Surface("lower_face") = {6};
Physical Surface("upper_face") = {11};
"""

# The geometry of each case, Young's modulus [Pa], Poisson's ratio, density [kg/m^3], steps, their length [s] (0: static), the way of
# the lid [m] or the velocity of the upper body [m/s].
CASES = {
    "patch": dict(coarse=0.08, fine=0.06, order=1, gap=1e-5, inset=0.0, E=125.0, nu=0.25, rho=0.0, steps=4, dt=0.0, push=0.01),
    "patch, quadratic": dict(coarse=0.16, fine=0.12, order=2, gap=1e-5, inset=0.0, E=125.0, nu=0.25, rho=0.0, steps=4, dt=0.0, push=0.01),
    "impact": dict(coarse=0.058, fine=0.05, order=1, gap=4e-4, inset=0.2, E=1e6, nu=0.3, rho=1000.0, steps=20, dt=2e-4, push=1.0),
}


# GetFEM's side of a static case; a program of its own, because it times its steps without the set-up.
GETFEM = """import sys, time
import getfem as gf
path, order, E, nu, stiffness, steps, push = sys.argv[1], int(sys.argv[2]), *map(float, sys.argv[3:6]), int(sys.argv[6]), float(sys.argv[7])
lower, upper, bottom, lid, lower_face, upper_face = range(1, 7)
gf.util_trace_level(0), gf.util_warning_level(0)
model = gf.Model("real")
for name, value in dict(lam=E * nu / ((1 + nu) * (1 - 2 * nu)), mu=E / (2 * (1 + nu)), stiffness=stiffness).items():
    model.add_initialized_data(name, [value])
for name in ("way", "held"):
    model.add_initialized_data(name, [0, 0, 0])
spaces = {}
for name, other in (("u_lower", upper), ("u_upper", lower)):
    mesh = gf.Mesh("import", "gmsh", path)
    mesh.del_convex(mesh.region(other)[0])
    space = gf.MeshFem(mesh, 3)
    space.set_classical_fem(order)
    spaces[name] = (gf.MeshIm(mesh, gf.Integ(f"IM_TETRAHEDRON({2 if order == 1 else 5})")), space, mesh)
    model.add_fem_variable(name, space)
    model.add_isotropic_linearized_elasticity_brick(spaces[name][0], name, "lam", "mu")
model.add_Dirichlet_condition_with_simplification("u_lower", bottom, "held")
model.add_Dirichlet_condition_with_simplification("u_upper", lid, "way")
model.add_penalized_contact_between_nonmatching_meshes_brick(spaces["u_upper"][0], "u_upper", "u_lower", "stiffness", upper_face,
                                                             lower_face, 1)
iterations, begin = 0, time.perf_counter()
for k in range(1, steps + 1):
    model.set_variable("way", [0, 0, -push * k / steps])
    done, converged = model.solve("max_res", 1e-9, "max_iter", 50, "lsolver", "mumps")
    if not converged:
        sys.exit(f"no equilibrium in step {k}")
    iterations += done
seconds = time.perf_counter() - begin
integration, space, mesh = spaces["u_lower"]
constants = gf.MeshFem(mesh, 1)
constants.set_classical_fem(0)
full = lambda name: [model.variable(name)[0]] * constants.nbdof()
forces = gf.asm_linear_elasticity(integration, space, constants, full("lam"), full("mu")).mult(model.variable("u_lower"))
print(seconds, abs(forces[space.basic_dof_on_region(bottom)][2::3].sum()), iterations)
"""


class Failure(Exception):
    """A run that did not do what it should."""


def run(command, directory, threads=1):
    environment = os.environ | {"OMP_NUM_THREADS": str(threads), "CCX_NPROC_EQUATION_SOLVER": str(threads)}
    begin = time.perf_counter()
    done = subprocess.run(command, cwd=directory, env=environment, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - begin
    if done.returncode != 0:
        raise Failure(f"{' '.join(command)}\n{done.stdout[-1500:]}{done.stderr[-1500:]}")
    return done.stdout + done.stderr, seconds


def make_mesh(case, directory):
    with open(os.path.join(directory, "two.geo"), "w", encoding="ascii") as file:
        file.write(GEOMETRY % case)
    run(["gmsh", "-3", "-format", "msh22", "two.geo", "-o", "two.msh"], directory)
    return meshio.read(os.path.join(directory, "two.msh"))


def pliant(case, ranks, directory, law):
    is_static = case["dt"] == 0.0
    density = "" if is_static else f"density: {case['rho']}, "
    model = "linear" if is_static else "saint-venant-kirchhoff"
    body = f"{density}elasticity: {{model: {model}, youngs_modulus: {case['E']}, poissons_ratio: {case['nu']}}}"
    lid = f', {{surface: lid, displacement: [0, 0, {-case["push"]}]}}' if is_static else ""
    moves = "" if is_static else f'initial: {{velocity: [0, 0, "z > 1.0001 ? {-case["push"]} : 0"]}}\n'
    steps = f"method: static, load_steps: {case['steps']}" if is_static else \
        f"method: backward-euler, step: {case['dt']}, end: {case['steps'] * case['dt']}"
    with open(os.path.join(directory, "two.yaml"), "w", encoding="ascii") as file:
        file.write(f"""mesh: {{file: two.msh}}
element: P{case['order']}
bodies: [{{volume: lower, {body}}}, {{volume: upper, {body}}}]
constraints: [{{surface: bottom, displacement: [0, 0, 0]}}{lid}]
{moves}contact: {{law: {law}, pairs: [{{name: pair, surface: upper, with: lower}}]}}
time: {{{steps}}}
output: {{every: {1.0 if is_static else case['steps'] * case['dt']}}}
""")
    text, _ = run(["mpirun", "--quiet", "--bind-to", "none", "--oversubscribe", "-n", str(ranks), PLIANT, "run", "two.yaml"], directory)
    total, set_up = (float(re.search(rf"^time:.*?{key}([\d.]+)", text, re.M)[1]) for key in ("", "set-up "))
    table = np.genfromtxt(os.path.join(directory, "out", "two", "history.csv"), delimiter=",", names=True)
    newton = int(re.search(r"^newton: (\d+)", text, re.M)[1])
    return (total - set_up) / case["steps"], np.abs(table["pair_fz"]).max(), newton


def listed(numbers):
    lines = [", ".join(map(str, numbers[i:i + 8])) for i in range(0, len(numbers), 8)]
    return ",\n".join(lines) + "\n"


def calculix_input(case, mesh):
    """The model: nodes and elements are numbered from 1, volumes by sets, the faces that touch by surfaces."""
    kind, triangle, title = ("tetra10", "triangle6", "C3D10") if case["order"] == 2 else ("tetra", "triangle", "C3D4")
    names = {(tag, dimension): name for name, (tag, dimension) in mesh.field_data.items()}
    text, first, face_of = "*NODE, NSET=all\n", 1, {}
    text += "".join(f"{n + 1}, {x:.16g}, {y:.16g}, {z:.16g}\n" for n, (x, y, z) in enumerate(mesh.points))
    groups, size = {}, 0
    parts = [(block.type, tag, block.data[tags == tag]) for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"])
             if block.type in (kind, triangle) for tag in np.unique(tags)]
    upper = []
    for shape, tag, members in parts:
        name = names[tag, 2 if shape == triangle else 3]
        if shape == triangle:
            groups.setdefault(name, []).append(members)
            continue
        if name == "upper":
            upper = np.unique(members) + 1
        text += f"*ELEMENT, TYPE={title}, ELSET={name}\n"
        for number, cell in enumerate(members, start=first):
            text += listed([number, *(cell + 1)])
            for f, corners in enumerate(FACES, start=1):
                face_of[tuple(sorted(cell[list(corners)]))] = (number, f)
        first += len(members)
        size += len(members)
    for name, blocks in groups.items():
        nodes = np.unique(np.concatenate(blocks)) + 1
        text += f"*NSET, NSET={name}\n" + listed(list(nodes))
        if name.endswith("_face"):
            faces = [face_of[tuple(sorted(t[:3]))] for block in blocks for t in block]
            text += f"*SURFACE, NAME=S_{name}, TYPE=ELEMENT\n" + "".join(f"{e}, S{f}\n" for e, f in faces)
    is_static = case["dt"] == 0.0
    text += f"*MATERIAL, NAME=rubber\n*ELASTIC\n{case['E']}, {case['nu']}\n" + ("" if is_static else f"*DENSITY\n{case['rho']}\n")
    text += "".join(f"*SOLID SECTION, ELSET={name}, MATERIAL=rubber\n" for name in ("lower", "upper"))
    text += f"*SURFACE INTERACTION, NAME=touch\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n{stiffness_of(case):.6g}\n"
    text += "*CONTACT PAIR, INTERACTION=touch, TYPE=SURFACE TO SURFACE\nS_upper_face, S_lower_face\n"
    text += "*BOUNDARY\nbottom, 1, 3\n"
    if is_static:
        text += f"*STEP\n*STATIC, DIRECT\n{1.0 / case['steps']}, 1.\n*BOUNDARY\nlid, 1, 2\nlid, 3, 3, {-case['push']}\n"
    else:
        text += "*NSET, NSET=flying\n" + listed(list(upper))
        text += f"*INITIAL CONDITIONS, TYPE=VELOCITY\nflying, 3, {-case['push']}\n"
        text += f"*STEP, NLGEOM, INC=100000\n*DYNAMIC, DIRECT\n{case['dt']}, {case['steps'] * case['dt']}\n"
    return text + "*NODE PRINT, NSET=bottom, TOTALS=ONLY\nRF\n*END STEP\n", size


def calculix(case, mesh, threads, directory):
    text, size = calculix_input(case, mesh)
    with open(os.path.join(directory, "ccx.inp"), "w", encoding="ascii") as file:
        file.write(text)
    log, seconds = run(["ccx", "ccx"], directory, threads)
    with open(os.path.join(directory, "ccx.dat"), encoding="ascii") as file:
        forces = [float(line.split()[2]) for line in file if len(line.split()) == 3 and "E" in line]
    if not forces:
        raise Failure(log[-1500:])
    iterations = len(re.findall(r"iteration \d+", log))
    return seconds / case["steps"], np.abs(forces).max(), iterations, size


def stiffness_of(case):
    """Of the peers' penalty [Pa/m]. A stiffer spring stops an impact on it."""
    return (50.0 if case["dt"] == 0.0 else 10.0) * case["E"] / case["fine"]


def getfem(case, directory):
    script = os.path.join(directory, "two.py")
    with open(script, "w", encoding="ascii") as file:
        file.write(GETFEM)
    numbers = [case["order"], case["E"], case["nu"], stiffness_of(case), case["steps"], case["push"]]
    log, _ = run(["/usr/bin/python3", script, "two.msh", *map(str, numbers)], directory)
    seconds, force, iterations = map(float, log.split()[-3:])
    return seconds / case["steps"], force, int(iterations)


def compare(name, ranks, directory):
    case = CASES[name]
    mesh = make_mesh(case, directory)
    row = {}
    for law in ("penalty", "barrier"):
        row[law] = pliant(case, ranks, directory, law)
    seconds, force, iterations, size = calculix(case, mesh, ranks, directory)
    peers = {"CalculiX": (seconds, force, iterations)}
    if case["dt"] == 0.0 and ranks == 1:
        peers["GetFEM"] = getfem(case, directory)
    fastest = min(seconds for seconds, _, _ in peers.values())
    # Of an impact nothing has come to the bottom yet.
    with_force = (lambda newtons: f", force {newtons:.4g} N") if case["dt"] == 0.0 else (lambda _: "")
    print(f"{name}, {size} tetrahedra, {ranks} rank{'s' if ranks > 1 else ''}")
    for peer, (seconds, force, iterations) in peers.items():
        print(f"    {peer}: {seconds:.3g} s a step, {iterations} iterations{with_force(force)}")
    for law, (own, own_force, newton) in row.items():
        print(f"    Pliant, {law}: {own:.3g} s a step, {newton} iterations{with_force(own_force)}; ratio {own / fastest:.2f}")
    sys.stdout.flush()


def main():
    parser = Parser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", metavar="CASE", help=f"of {', '.join(CASES)}; default: all")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    options = parser.parse_args()
    unknown = [name for name in options.cases if name not in CASES]
    if unknown:
        parser.error(f"no case '{unknown[0]}'; the cases are: {', '.join(CASES)}")
    try:
        for name in options.cases or CASES:
            for ranks in options.ranks:
                with tempfile.TemporaryDirectory() as directory:
                    compare(name, ranks, directory)
    except (Failure, FileNotFoundError) as error:
        return report("bench_contact.py", error)
    return 0


if __name__ == "__main__":
    sys.exit(main())
