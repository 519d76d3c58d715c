"""Meshes of triangles for the tests of free shells: patches mapped from a square, and balls."""
import numpy as np

from program import LINE, TRIANGLE

POINT = 15


def write_shell(path, nodes, triangles, curves=None, points=None):
    """A mesh in gmsh's format 2.2 with the physical surface 'sheet', physical curves (their edges) and points (their node)."""
    groups, elements = [(2, "sheet")], [(TRIANGLE, 1, triangle) for triangle in triangles]
    for name, edges in (curves or {}).items():
        groups.append((1, name))
        elements += [(LINE, len(groups), edge) for edge in edges]
    for name, node in (points or {}).items():
        groups.append((0, name))
        elements.append((POINT, len(groups), (node,)))
    with open(path, "w", encoding="ascii") as out:
        out.write(f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(groups)}\n")
        for number, (dimension, name) in enumerate(groups, 1):
            out.write(f'{dimension} {number} "{name}"\n')
        out.write(f"$EndPhysicalNames\n$Nodes\n{len(nodes)}\n")
        for number, x in enumerate(nodes, 1):
            out.write("{} {:.17g} {:.17g} {:.17g}\n".format(number, *x))
        out.write(f"$EndNodes\n$Elements\n{len(elements)}\n")
        for number, (kind, group, members) in enumerate(elements, 1):
            out.write(f"{number} {kind} 2 {group} {group} {' '.join(str(n + 1) for n in members)}\n")
        out.write("$EndElements\n")


def write_patch(path, n, place, alternate=False, jitter=0.0):
    """n x n squares in two triangles each, cut along one diagonal or `alternate` ones; place(s, t): where a point of the unit
    square lies. Curves s0, s1, t0, t1 and points p00, p10, p01, p11."""
    m = n if isinstance(n, tuple) else (n, n)
    random = np.random.default_rng(1)
    number = lambda i, j: j * (m[0] + 1) + i
    square = np.array([(i / m[0], j / m[1]) for j in range(m[1] + 1) for i in range(m[0] + 1)])
    inner = np.all((square > 1e-9) & (square < 1 - 1e-9), axis=1)
    square[inner] += jitter * random.uniform(-1, 1, (inner.sum(), 2)) / m
    triangles = []
    for j in range(m[1]):
        for i in range(m[0]):
            a, b, c, d = number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)
            triangles += [(a, b, d), (b, c, d)] if alternate and (i + j) % 2 else [(a, b, c), (a, c, d)]
    curves = {
        "s0": [(number(0, j), number(0, j + 1)) for j in range(m[1])],
        "s1": [(number(m[0], j), number(m[0], j + 1)) for j in range(m[1])],
        "t0": [(number(i, 0), number(i + 1, 0)) for i in range(m[0])],
        "t1": [(number(i, m[1]), number(i + 1, m[1])) for i in range(m[0])],
    }
    points = {"p00": number(0, 0), "p10": number(m[0], 0), "p01": number(0, m[1]), "p11": number(m[0], m[1])}
    write_shell(path, [place(s, t) for s, t in square], triangles, curves, points)


def write_ball(path, divisions, radius=1.0):
    """An octahedron, each side divided, on the sphere."""
    places, triangles = {}, []
    for signs in np.ndindex(2, 2, 2):
        sign = 1 - 2 * np.array(signs)
        at = lambda i, j: places.setdefault(tuple(sign * np.array((i, j, divisions - i - j)) + 0), len(places))
        for i in range(divisions):
            for j in range(divisions - i):
                corners = [(at(i, j), at(i + 1, j), at(i, j + 1))]
                if i + j < divisions - 1:
                    corners.append((at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)))
                triangles += corners
    nodes = np.array(list(places), float)
    write_shell(path, radius * nodes / np.linalg.norm(nodes, axis=1)[:, None], triangles)
