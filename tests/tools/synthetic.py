"""A result as Pliant writes it, made without Pliant: a cantilever of quadratic tetrahedra that swings, with its history."""
import itertools
import os
import sys

import h5py
import numpy as np

LENGTH, WIDTH, HEIGHT = 1.0, 0.2, 0.2
MODULUS = 1e6  # [Pa]


def block(cubes, order):
    """Nodes and tetrahedra of a block of cubes, six of equal volume in each."""
    shape = [n + 1 for n in cubes]
    grid = np.stack(np.meshgrid(*[np.arange(n) for n in shape], indexing="ij"), axis=-1).reshape(-1, 3)
    x = grid / np.array(cubes) * [LENGTH, WIDTH, HEIGHT] - [0, WIDTH / 2, HEIGHT / 2]
    number = np.arange(len(grid)).reshape(shape)
    cells = []
    for corner in itertools.product(*[range(n) for n in cubes]):
        for axes in itertools.permutations(range(3)):
            at, cell = list(corner), [number[corner]]
            for axis in axes:
                at[axis] += 1
                cell.append(number[tuple(at)])
            if axes not in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                cell[1], cell[2] = cell[2], cell[1]
            cells.append(cell)
    cells = np.array(cells)
    if order == 1:
        return x, cells
    ends = np.sort(cells[:, [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]].reshape(-1, 2), axis=1)
    unique, index = np.unique(ends, axis=0, return_inverse=True)
    middles = index.reshape(-1, 6) + len(x)
    return np.vstack([x, x[unique].mean(axis=1)]), np.hstack([cells, middles])


def bent(x, angle):
    """Displacement of a bar bent into an arc that ends at `angle`."""
    if abs(angle) < 1e-12:
        return np.zeros_like(x)
    radius = LENGTH / angle
    phi = x[:, 0] / radius
    r = radius - x[:, 2]
    return np.stack([r * np.sin(phi), x[:, 1], radius - r * np.cos(phi)], axis=1) - x


def write_result(directory, num_frames=6, order=2, cubes=(10, 2, 2), title="cantilever under gravity"):
    os.makedirs(directory, exist_ok=True)
    x, cells = block(cubes, order)
    middle = x[cells[:, :4]].mean(axis=1)
    times = np.linspace(0, 1, num_frames)
    with h5py.File(os.path.join(directory, "result.h5"), "w") as h5:
        h5.attrs.update({"format": "pliant-result", "version": 1, "title": title})
        mesh = h5.create_group("mesh")
        mesh["coordinates"], mesh["cells"] = x, cells.astype("i8")
        mesh["body"] = (middle[:, 0] > LENGTH / 2).astype("i4")
        mesh["body"].attrs["names"] = "root\ntip"
        mesh["rank"] = (np.arange(len(cells)) * 2 // len(cells)).astype("i4")
        for i, t in enumerate(times):
            frame = h5.create_group(f"frames/{i:06}")
            frame.attrs.update({"time": t, "step": 10 * i, "mesh": "/mesh"})
            angle = -0.6 * (1 - np.cos(2 * np.pi * t))
            rate = -0.6 * 2 * np.pi * np.sin(2 * np.pi * t)
            stress = np.zeros((len(cells), 6))
            stress[:, 0] = -MODULUS * angle * middle[:, 2]
            fields = {"displacement": (bent(x, angle), "m", "node"),
                      "velocity": ((bent(x, angle + 1e-6) - bent(x, angle)) / 1e-6 * rate, "m/s", "node"),
                      "cauchy_stress": (stress, "Pa", "cell")}
            for name, (values, unit, location) in fields.items():
                frame[name] = values
                frame[name].attrs.update({"unit": unit, "location": location})


def add_obstacles(directory):
    """A floor below the bar's lowest point, and a pyramid that rises before it (y < 0), as wide as half the bar."""
    pyramid = np.array([[0, -0.5, -1.2], [0.5, -0.5, -1.2], [0.25, -0.3, -1.2], [0.25, -0.4, -0.8]])
    with h5py.File(os.path.join(directory, "result.h5"), "r+") as h5:
        group = h5.create_group("obstacles")
        floor = np.array([[-1, -1, -0.6], [1, -1, -0.6], [1, 1, -0.6], [-1, 1, -0.6]])
        group["points"] = np.vstack([floor, pyramid])
        group["triangles"] = np.array([[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 5, 7], [5, 6, 7], [6, 4, 7]])
        group["obstacle"] = np.array([0, 0, 1, 1, 1, 1], dtype="i4")
        group["obstacle"].attrs["names"] = "floor\npyramid"
        for frame in h5["frames"].values():
            lifted = pyramid + [0, 0, frame.attrs["time"]]
            group[f"frames/{frame.attrs['step']:06}/points"] = np.vstack([floor, lifted])


def add_mechanisms(directory):
    """A tendon from above the bar's root into its middle, a spring below the bar, and a hinge at the bar's root."""
    at_rest = np.array([[0, 0, 0.5], [0.2, 0, 0.2], [0.25, 0, 0], [0.9, 0, 0],
                        [0.2, 0, -0.5], [0.8, 0, -0.5],
                        [0, 0, 0], [0, -0.2, 0], [0, 0.2, 0]])
    with h5py.File(os.path.join(directory, "result.h5"), "r+") as h5:
        group = h5.create_group("mechanisms")
        group["points"] = at_rest
        group["segments"] = np.array([[0, 1], [1, 2], [2, 3], [4, 5], [7, 8]])
        group["part"] = np.array([0, 0, 0, 1, 2], dtype="i4")
        group["part"].attrs.update({"names": "flexor\ncoil\nroot_hinge", "kinds": "tendon\nspring\nhinge"})
        group["joints"] = np.array([6])
        for frame in h5["frames"].values():
            t = frame.attrs["time"]
            now = group.create_group(f"frames/{frame.attrs['step']:06}")
            now["points"] = at_rest + bent(at_rest, -0.6 * (1 - np.cos(2 * np.pi * t))) * [[0], [0], [1], [1], [0], [0], [0], [0], [0]]
            now["tension"] = np.array([8, 7, 5, -2, 0]) * t
            now["axes"] = np.array([[0.0, 1, 0]])


def add_vessel(directory):
    """A box around everything, whose triangles face its inside, as those of obstacles with `side: inside` do."""
    corners = np.array(list(itertools.product((-4, 5), (-4, 4), (-4, 4))), dtype=float)
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])  # counterclockwise from outside
    with h5py.File(os.path.join(directory, "result.h5"), "r+") as h5:
        group = h5.create_group("obstacles")
        group["points"] = corners
        group["triangles"] = np.vstack([faces[:, [0, 2, 1]], faces[:, [0, 3, 2]]])
        group["obstacle"] = np.zeros(12, dtype="i4")
        group["obstacle"].attrs["names"] = "vessel"


def add_rods(directory, has_wire=True):
    """A fibre along the axis of the bar of linear tetrahedra, which is a body without cells, and a rod `wire` of two segments before it (y < 0),
    with the forces 1 and 3 N. They stay where they are."""
    x = np.array([[0.2, -0.4, 0], [0.5, -0.4, 0], [0.8, -0.4, 0], [0.35, -0.38, 0], [0.35, -0.4, 0.02], [0.65, -0.38, 0], [0.65, -0.4, 0.02]])
    cells = np.array([[0, 1, 3, 4], [1, 2, 5, 6]])[:2 * has_wire]
    with h5py.File(os.path.join(directory, "result.h5"), "r+") as h5:
        def extend(group, name, rows, **attributes):
            values, known = group[name][()], {**group[name].attrs, **attributes}
            del group[name]
            group[name] = np.concatenate([values, rows.astype(values.dtype)])
            group[name].attrs.update(known)

        mesh, num_nodes, num_cells = h5["mesh"], len(h5["mesh/coordinates"]), len(h5["mesh/cells"])
        extend(mesh, "coordinates", x)
        extend(mesh, "cells", num_nodes + cells)
        extend(mesh, "body", np.full(len(cells), 3), names="root\ntip\nfibre\nwire", rods="fibre\nwire")
        extend(mesh, "rank", np.zeros(len(cells)))
        group = h5.create_group("mechanisms")
        lines = np.vstack([[[0.1, 0, 0], [0.9, 0, 0]], x[:3]])[:5 if has_wire else 2]
        group["points"] = lines
        group["segments"] = np.array([[0, 1], [2, 3], [3, 4]])[:len(lines) - 2 or 1]
        group["part"] = np.array([0, 1, 1], dtype="i4")[:len(group["segments"])]
        group["part"].attrs.update({"names": "fibre\nwire" if has_wire else "fibre", "kinds": "rod\nrod" if has_wire else "rod"})
        for frame in h5["frames"].values():
            for name in ("displacement", "velocity"):
                extend(frame, name, np.zeros((len(x), 3)))
            extend(frame, "cauchy_stress", np.zeros((len(cells), 6)))
            frame["rod_force"] = np.append(np.zeros(num_cells), [1.0, 3.0][:len(cells)])
            frame["rod_force"].attrs.update({"unit": "N", "location": "cell"})
            now = group.create_group(f"frames/{frame.attrs['step']:06}")
            now["points"], now["tension"] = lines, np.array([7.0, 1, 3])[:len(group["segments"])]


def write_history(directory, num_steps=200):
    t = np.linspace(0, 1, num_steps + 1)
    phase = 2 * np.pi * t
    loss = 2 * t
    columns = {
        "step": np.arange(num_steps + 1), "time": t, "dt": np.where(t > 0, 1 / num_steps, 0),
        "newton_iterations": np.where(t > 0, 3 + (np.sin(3 * phase) > 0.5), 0),
        "linear_iterations": np.where(t > 0, 9, 0),
        "kinetic_energy": 4 * np.sin(phase) ** 2, "elastic_energy": 5 * (1 - np.cos(phase)) / 2,
        "load_potential": -4 * np.sin(phase) ** 2 - 5 * (1 - np.cos(phase)) / 2 - loss,
        "dissipated_energy": loss, "load_work": 0 * t, "energy_balance_error": 1e-9 * t * np.cos(phase),
        "px": 0 * t, "py": 0 * t, "pz": np.sin(phase), "Lx": 0 * t, "Ly": 0 * t, "Lz": 0 * t,
        "floor_fx": 0 * t, "floor_fy": 0 * t, "floor_fz": 10 * np.maximum(0, np.sin(phase)),
        "tip_x": 1 - 0.1 * np.sin(phase) ** 2, "tip_y": 0 * t, "tip_z": -0.5 * (1 - np.cos(phase)) / 2,
        "tip_vx": 0 * t, "tip_vy": 0 * t, "tip_vz": -0.5 * np.pi * np.sin(phase),
        "clamp_fx": 0 * t, "clamp_fy": 0 * t, "clamp_fz": 100 + 20 * np.cos(phase),
    }
    with open(os.path.join(directory, "history.csv"), "w", encoding="utf-8") as file:
        file.write(",".join(columns) + "\n")
        for row in zip(*columns.values()):
            file.write(",".join(f"{value:.17g}" for value in row) + "\n")


if __name__ == "__main__":
    write_result(sys.argv[1], num_frames=25, cubes=(20, 4, 4))
    write_history(sys.argv[1])
