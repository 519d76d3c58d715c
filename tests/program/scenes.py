"""Random scenes of bodies that hit one another: a mesh and an input from a seed.

    scene = write_scene(seed, directory)

A scene has two to eight bodies of random shape, material, place and velocity, a method, and contact by barriers. Whatever it draws, a
run must succeed, and no surface may pass another. Each aspect draws from a stream of its own, so that a new one leaves the others as
they are. All lengths are in metres, and so on in SI.
"""
import dataclasses
import itertools
import json
import math
import pathlib
import random

import numpy as np

from program import TETRAHEDRON, box

METHODS = {"backward-euler": 4, "bdf2": 6, "dirk22": 4, "dirk33": 3, "bdf3": 2, "quasistatic": 1}
REFUSED = ("implicit-midpoint", "dirk23", "symplectic-dirk22")  # not stiffly accurate
LAWS = {"neo-hookean": 6, "neo-hookean-isochoric": 1, "stable-neo-hookean": 2, "mooney-rivlin": 1, "gent": 1, "fixed-corotated": 1,
        "linear": 1, "saint-venant-kirchhoff": 1}
LAWS_WITH_VOLUME = {"neo-hookean": 4, "neo-hookean-isochoric": 1, "mooney-rivlin": 1, "gent": 1}  # those with a volumetric part
SHAPES = {"box": 4, "plate": 4, "rod": 3, "bracket": 2, "tetrahedron": 2, "ball": 2, "drum": 2}  # of the writer below
TUBE = 0.3  # of the radius of a torus
SOLIDS = {"Box": 3, "Sphere": 3, "Cylinder": 3, "Cone": 2, "Torus": 1, "Wedge": 2}  # of gmsh


class Stream(random.Random):
    """Random numbers for one aspect of a scene."""

    def __init__(self, seed, aspect):
        super().__init__(f"{seed} {aspect}")

    def chance(self, probability):
        return self.random() < probability

    def of(self, weights):
        return self.choices(list(weights), list(weights.values()))[0]

    def logarithmic(self, low, high):
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def direction(self):
        v = np.array([self.gauss(0, 1) for _ in range(3)])
        return v / np.linalg.norm(v)


@dataclasses.dataclass
class Body:
    """A body of size about 1, at first around the origin."""

    name: str
    corners: np.ndarray  # shape (points, 3); all of the body lies between them
    size: float = 1.0
    cells: np.ndarray = None  # None: gmsh makes them
    solid: tuple = ()  # for gmsh: its kind and parameters
    largest_facet: float = 1.0  # with which gmsh can mesh it
    rotation: np.ndarray = dataclasses.field(default_factory=lambda: np.eye(3))
    axis_angle: tuple = ((0, 0, 1), 0.0)
    place: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros(3))

    def points(self):
        return self.size * self.corners @ self.rotation.T + self.place

    def bounds(self):
        return self.points().min(axis=0), self.points().max(axis=0)


@dataclasses.dataclass
class Scene:
    """A scene on disk, and what is known of its run."""

    seed: int
    input: pathlib.Path
    ranks: int
    method: str
    element: str
    names: list
    touching: set  # pairs (i, j), i <= j, of bodies that may touch
    is_refused: bool  # the method does not go with barriers
    is_free: bool  # nothing from outside acts on the bodies
    obstacle: dict  # kind and place, or None
    step: float
    num_steps: int
    thickness: float
    speed: float  # of the fastest body
    strain_energy: float  # of the largest and stiffest body at a strain of about 1 [J]


# Shapes.

def trimmed(points, cells):
    """Without the points that no cell has."""
    used, cells = np.unique(cells, return_inverse=True)
    return points[used], cells.reshape(-1, 4)


def to_ball(points, part, axes):
    """Moves points of [-1, 1]^3 so that squares across these axes become round, by `part` of the way."""
    p = points.copy()
    for a in axes:
        b, c = (k for k in range(3) if k != a) if len(axes) == 3 else (next(k for k in axes if k != a),) * 2
        y, z = points[:, b] ** 2, points[:, c] ** 2
        factor = 1 - y / 2 - z / 2 + y * z / 3 if b != c else 1 - y / 2
        p[:, a] = points[:, a] * (1 + part * (np.sqrt(factor) - 1))
    return p


def grid(rng, shape):
    """Points between -1/2 and 1/2 and tetrahedra of one of SHAPES."""
    if shape == "tetrahedron":
        points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]) + [[rng.uniform(-0.2, 0.2) for _ in range(3)] for _ in range(4)]
        return points - 0.4, np.array([[0, 1, 2, 3]])
    lengths, n = {"plate": ((1, rng.uniform(0.5, 1), rng.logarithmic(0.02, 0.1)), (rng.randint(2, 4), rng.randint(2, 4), 1)),
                  "rod": ((1, *[rng.logarithmic(0.03, 0.15)] * 2), (rng.randint(4, 8), 1, 1)),
                  "bracket": ((1, rng.uniform(0.5, 1), rng.uniform(0.1, 0.4)), (2, 2, 1)),
                  "box": ([rng.uniform(0.3, 1) for _ in range(3)], [rng.randint(1, 3) for _ in range(3)]),
                  "ball": ((1, 1, 1), (2, 2, 2)),
                  "drum": ((0.5, 0.5, rng.uniform(0.2, 1)), (2, 2, rng.randint(1, 2)))}[shape]
    lengths = np.array(lengths)
    points, _, cells = box(n, (2, 2, 2), origin=(-1, -1, -1))
    if shape == "bracket":  # without one of its quarters
        middle = points[cells].mean(axis=1)
        points, cells = trimmed(points, cells[(middle[:, 0] < 0) | (middle[:, 1] < 0)])
    if shape in ("ball", "drum"):
        points = to_ball(points, 0.7, (0, 1, 2) if shape == "ball" else (0, 1))
    return 0.5 * points * lengths, cells


def solid(rng, kind):
    """Parameters of a solid of gmsh, and the corners of a box around it."""
    r, s = rng.uniform(0.2, 0.5), rng.uniform(0.05, 0.5)
    if kind == "Sphere":
        return f"{{0, 0, 0, {r}}}", [(-r, -r, -r), (r, r, r)]
    if kind == "Cylinder":
        return f"{{0, 0, {-s}, 0, 0, {2 * s}, {r}}}", [(-r, -r, -s), (r, r, s)]
    if kind == "Cone":
        return f"{{0, 0, {-s}, 0, 0, {2 * s}, {r}, {0.3 * r}}}", [(-r, -r, -s), (r, r, s)]
    if kind == "Torus":
        t = TUBE * r
        return f"{{0, 0, 0, {r}, {t}}}", [(-r - t, -r - t, -t), (r + t, r + t, t)]
    if kind == "Wedge":
        return f"{{{-r}, {-r}, {-s}, {2 * r}, {2 * r}, {2 * s}, {0.3 * r}}}", [(-r, -r, -s), (r, r, s)]
    return f"{{{-r}, -0.5, {-s}, {2 * r}, 1, {2 * s}}}", [(-r, -0.5, -s), (r, 0.5, s)]


def make_bodies(seed, is_of_gmsh):
    """Without their places."""
    rng = Stream(seed, "bodies")
    bodies = []
    number = rng.randint(2, 5 if is_of_gmsh else 8)
    size = rng.logarithmic(0.02, 0.4)
    for k in range(number):
        if is_of_gmsh:
            kind = rng.of(SOLIDS)
            parameters, (low, high) = solid(rng, kind)
            body = Body(f"b{k}", np.array(list(itertools.product(*zip(low, high)))), solid=(kind, parameters))
            if kind == "Torus":  # four around the tube
                body.largest_facet = 1.5 * high[2]
        else:
            points, cells = grid(rng, rng.of(SHAPES))
            body = Body(f"b{k}", points, cells=cells)
        body.size = size * rng.logarithmic(0.5, 2)
        if rng.chance(0.6):  # the others have parallel faces
            axis, angle = rng.direction(), -rng.uniform(0, math.pi)
            body.axis_angle = (axis.tolist(), angle)
            cross = np.cross(np.eye(3), axis)
            body.rotation = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
        bodies.append(body)
    return bodies


def place_bodies(seed, bodies):
    """Apart, but close to one another: as a heap, or around the origin. Returns the least distance along an axis."""
    rng = Stream(seed, "places")
    gap = rng.logarithmic(0.005, 0.1) * min(body.size for body in bodies)
    is_heap = rng.chance(0.3)
    for k, body in enumerate(bodies[1:], 1):
        way = np.array([rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), 1.0]) if is_heap else rng.direction()
        while any(overlap(body.bounds(), other.bounds(), gap) for other in bodies[:k]):
            body.place = body.place + 0.02 * body.size * way
    return gap


def overlap(first, second, gap):
    return bool((first[0] < second[1] + gap).all() and (second[0] < first[1] + gap).all())


# Files.

def write_grids(path, bodies):
    """A gmsh 2.2 file with a physical volume per body."""
    first, nodes, elements = 1, [], []
    for tag, body in enumerate(bodies, 1):
        nodes += body.points().tolist()
        elements += [f"{TETRAHEDRON} 2 {tag} {tag} " + " ".join(map(str, cell + first)) for cell in oriented(body)]
        first = len(nodes) + 1
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(bodies)),
             *(f'3 {tag} "{body.name}"' for tag, body in enumerate(bodies, 1)), "$EndPhysicalNames",
             "$Nodes", str(len(nodes)), *(f"{k} {x!r} {y!r} {z!r}" for k, (x, y, z) in enumerate(nodes, 1)), "$EndNodes",
             "$Elements", str(len(elements)), *(f"{k} {element}" for k, element in enumerate(elements, 1)), "$EndElements", ""]
    path.write_text("\n".join(lines), encoding="ascii")


def oriented(body):
    """Its cells, of positive volume."""
    cells, x = body.cells.copy(), body.points()
    sides = x[cells[:, 1:]] - x[cells[:, :1]]
    inverted = np.linalg.det(sides) < 0
    cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    return cells


def write_geometry(path, bodies, fineness):
    lines = ['SetFactory("OpenCASCADE");']
    for tag, body in enumerate(bodies, 1):
        (axis, angle), place = body.axis_angle, body.place.tolist()
        kind, parameters = body.solid
        lines += [f"{kind}({tag}) = {parameters};",
                  f"Dilate {{{{0, 0, 0}}, {body.size}}} {{ Volume{{{tag}}}; }}",
                  f"Rotate {{{{{', '.join(map(str, axis))}}}, {{0, 0, 0}}, {angle}}} {{ Volume{{{tag}}}; }}",
                  f"Translate {{{', '.join(map(str, place))}}} {{ Volume{{{tag}}}; }}",
                  f'Physical Volume("{body.name}") = {{{tag}}};',
                  f"MeshSize {{ PointsOf {{ Volume{{{tag}}}; }} }} = {body.size * min(fineness, body.largest_facet)};"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


# The input.

def held_part(body):
    """How much of a body's height is held or moved: so much that there are nodes. A body of gmsh may be far from the corners of its box,
    but not from the middle."""
    return 0.25 if body.solid == () else 0.5


def within(body, part=1.0):
    """A condition: points of the body, or of its lowest part along z."""
    low, high = body.bounds()
    margin = 1e-6 * body.size
    high[2] = low[2] + part * (high[2] - low[2])
    return " && ".join(f"{c} > {a - margin} && {c} < {b + margin}" for c, a, b in zip("xyz", low, high))


def elasticity(rng, laws, young, poisson):
    model = rng.of(laws)
    mu, kappa = young / (2 * (1 + poisson)), young / (3 * (1 - 2 * poisson))
    if model == "mooney-rivlin":
        return {"model": model, "c10": 0.4 * mu, "c01": 0.1 * mu, "bulk_modulus": kappa}
    if model == "gent":
        return {"model": model, "shear_modulus": mu, "stretch_limit": 50, "bulk_modulus": kappa}
    return {"model": model, "youngs_modulus": young, "poissons_ratio": poisson}


def stiffness(entry):
    law = entry["elasticity"]
    return law.get("youngs_modulus", law.get("bulk_modulus"))


def materials(seed, bodies, step, volumetric):
    rng = Stream(seed, "materials")
    entries = []
    one_for_all = rng.chance(0.3)
    for body in bodies:
        young, poisson = rng.logarithmic(1e4, 1e9), rng.choice((0, 0.3, 0.4, 0.45, 0.49))
        if volumetric == "mixed":  # needs a resistance to changes of volume
            poisson = max(poisson, 0.3)
        entry = {"volume": body.name, "density": round(rng.logarithmic(300, 8000)), "elasticity": elasticity(rng, LAWS if volumetric == "standard" else LAWS_WITH_VOLUME, young, poisson)}
        if rng.chance(0.2):
            time = rng.logarithmic(0.01, 1) * step
            entry["viscosity"] = [{"model": "stiffness-proportional", "time": time} if volumetric == "standard" else
                                  {"model": "kelvin-voigt", "shear": 0.3 * young * time}]
        if one_for_all and entries:
            entry = {**entries[0], "volume": body.name}
        entries.append(entry)
    return entries


def velocities(seed, bodies, least):
    """Of each body: towards the middle, or one shot at the others; some rotate. Returns v, w, both of shape (3,), for each."""
    rng = Stream(seed, "velocities")
    speed, is_shot = min(10.0, max(least, rng.logarithmic(0.1, 10))), rng.chance(0.3)
    result = []
    for k, body in enumerate(bodies):
        way = -body.place / (np.linalg.norm(body.place) + 1e-9) + 0.3 * rng.direction()
        v = way / np.linalg.norm(way) * speed * rng.uniform(0.2, 1)
        w = rng.direction() * rng.uniform(0, 2) * speed / body.size if rng.chance(0.3) else np.zeros(3)
        result.append((v, w) if k == 0 or not is_shot else (np.zeros(3), np.zeros(3)))
    return result


def velocity_formulas(bodies, motions):
    """One formula for each component, by the box in which the point lies."""
    formulas = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        text = "0"
        for body, (v, w) in zip(bodies, motions):
            spin = "" if not w.any() else f" + {w[i]}*({'xyz'[j]} - {body.place[j]}) - {w[j]}*({'xyz'[i]} - {body.place[i]})".replace("- -", "+ ")
            text = f"({within(body)}) ? ({v[k]}{spin}) : ({text})"
        formulas.append(text)
    return formulas


def drag(seed):
    """Friction and damping of an obstacle."""
    rng = Stream(seed, "drag")
    keys = {"friction": rng.uniform(0, 1), "viscous_friction": rng.uniform(0, 0.1), "normal_damping": rng.uniform(0, 0.5)}
    return {key: value for key, value in keys.items() if rng.chance(0.3)}


def obstacle(seed, bodies, gap):
    """A floor, one that rises, or a vessel; or None."""
    rng = Stream(seed, "obstacle")
    low = np.min([body.bounds()[0] for body in bodies], axis=0)
    high = np.max([body.bounds()[1] for body in bodies], axis=0)
    gap = max(gap, 0.05 * max(body.size for body in bodies))  # beyond the width of the barrier
    kind = rng.of({"none": 5, "floor": 3, "rising": 1, "vessel": 1})
    if kind == "none":
        return None
    if kind == "vessel":
        radius = 0.5 * float(np.linalg.norm(high - low)) + gap
        return {"name": "vessel", "shape": "sphere", "side": "inside", "point": (0.5 * (low + high)).tolist(), "radius": radius, **drag(seed)}
    entry = {"name": "floor", "shape": "plane", "point": [0, 0, float(low[2]) - gap], "normal": [0, 0, 1], **drag(seed)}
    if kind == "rising":
        entry["motion"] = {"translate": [0, 0, f"{rng.logarithmic(0.1, 2)}*t"]}
    return entry


def contact_between(seed, names, gap):
    """`contact` without its obstacles, the pairs that may touch, and the thickness."""
    rng = Stream(seed, "contact")
    every = {(i, j) for i in range(len(names)) for j in range(i, len(names))}
    contact = {"law": "barrier", "pairs": "all"}
    thickness = 0.0
    touching = every
    kind = rng.of({"all": 12, "list": 2, "exclude": 2})
    if kind == "list":
        touching = set(rng.sample(sorted(every), max(1, len(every) // 2)))
        contact["pairs"] = [{"surface": names[i]} if i == j else {"surface": names[i], "with": names[j]} for i, j in sorted(touching)]
    elif kind == "exclude":
        excluded = set(rng.sample([pair for pair in sorted(every) if pair[0] != pair[1]], 1))
        contact["exclude"] = [[names[i], names[j]] for i, j in sorted(excluded)]
        touching = every - excluded
    if rng.chance(0.2):
        thickness = rng.uniform(0.1, 0.5) * gap
        contact["threshold"] = thickness
    if rng.chance(0.15):
        contact["width"] = rng.logarithmic(0.05, 0.5) * (gap - thickness)
    rng = Stream(seed, "drag between")
    if rng.chance(0.3):
        contact["friction"] = rng.uniform(0, 1)
        contact["friction_update"] = rng.choice(("frozen", "iterated"))
    if rng.chance(0.1):
        contact["normal_damping"] = rng.uniform(0, 0.5)
    return contact, touching, thickness


def constraints(seed, bodies, motions, is_static):
    """One body is held, or moves as prescribed, with its velocity at the start; another one may be rigid."""
    rng = Stream(seed, "constraints")
    result = []
    kind = "moved" if is_static else rng.of({"none": 6, "held": 2, "moved": 2})
    if kind == "held":
        motions[-1] = (np.zeros(3), np.zeros(3))
        result.append({"where": within(bodies[-1], held_part(bodies[-1])), "displacement": [0, 0, 0]})
    if kind == "moved":
        v = motions[0][0]
        motions[0] = (v, np.zeros(3))
        place = {"volume": bodies[0].name} if rng.chance(0.5) else {"where": within(bodies[0], held_part(bodies[0]))}
        result.append({**place, "displacement": [f"{c}*t" for c in v]})
    if rng.chance(0.1) and len(bodies) > 2 and not is_static:
        result.append({"volume": bodies[1].name, "rigid": {}})
    return result


def write_scene(seed, directory):
    """Writes scene.yaml and its mesh into a directory that exists."""
    directory = pathlib.Path(directory)
    rng = Stream(seed, "scene")
    is_of_gmsh = rng.chance(0.3)
    method = rng.choice(REFUSED) if rng.chance(0.02) else rng.of(METHODS)
    is_static = method == "quasistatic"
    step, num_steps = rng.logarithmic(1e-3, 25e-3), rng.randint(10, 20)
    element = "P2" if rng.chance(0.3) else "P1"
    volumetric = rng.choice(("standard", "standard", "mean-dilatation", "mixed")) if element == "P2" else "standard"
    bodies = make_bodies(seed, is_of_gmsh)
    gap = place_bodies(seed, bodies)
    motions = velocities(seed, bodies, bodies[0].size / (step * num_steps))  # to meet in time
    held = constraints(seed, bodies, motions, is_static)
    entries = materials(seed, bodies, step, volumetric)
    contact, touching, thickness = contact_between(seed, [body.name for body in bodies], gap)
    around = None if is_static or any("displacement" in entry for entry in held) else obstacle(seed, bodies, gap)
    loads = [{"gravity": [0, 0, -9.81]}] if not is_static and rng.chance(0.7 if around else 0.1) else []
    if is_static:  # each body on springs, pushed by the first, by half of its size in all
        loads = [{"where": within(body), "spring": 0.05 * 1e5 / body.size} for body in bodies[1:]]
        reach = float(np.linalg.norm(motions[0][0])) * step * num_steps
        held[0]["displacement"] = [f"{c * 0.5 * bodies[0].size / reach}*t" for c in motions[0][0]]
    if is_of_gmsh:
        write_geometry(directory / "scene.geo", bodies, 0.6 if element == "P2" else rng.uniform(0.3, 0.6))
    else:
        write_grids(directory / "scene.msh", bodies)
    scene = {
        "mesh": {"file": "scene.geo" if is_of_gmsh else "scene.msh"},
        "element": element,
        "volumetric": volumetric,
        "bodies": entries,
        "constraints": held,
        "loads": loads,
        "contact": {**contact, **({"obstacles": [around]} if around else {})},
        "initial": {} if is_static else {"velocity": velocity_formulas(bodies, motions)},
        "time": {"method": method, "step": step, "end": step * num_steps},
        "output": {"fields": ["displacement", "velocity"]},
    }
    text = "".join(f"{key}: {json.dumps(value)}\n" for key, value in scene.items() if value)
    (directory / "scene.yaml").write_text(f"# Seed {seed}\n{text}", encoding="ascii")
    is_free = not around and not held and not loads
    return Scene(seed, directory / "scene.yaml", rng.choice((1, 1, 1, 2, 2, 3)), method, element, [body.name for body in bodies], touching,
                 method in REFUSED, is_free, around, step, num_steps, thickness,
                 max(float(np.linalg.norm(v)) for v, _ in motions),
                 max(stiffness(entry) for entry in entries) * max(body.size for body in bodies) ** 3)
