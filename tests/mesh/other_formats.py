"""One body of two volumes, with surfaces on its sides, in every format that other programs write, by hand.

All writers take a `Body` and return bytes (MED: write into a file), with the same nodes and elements in the same order. Formats with
names have those of the groups, the others their numbers.
"""
import base64
import pathlib
import struct
import sys
import zlib

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "program"))

from program import SIDES, box  # noqa: E402

SWAPPED = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]  # gmsh's order of nodes from that of VTK, Abaqus, Nastran and Medit, and back


class Body:
    """A box of 48 tetrahedra: volumes "near" (1, x < 1/2) and "far" (2), surfaces of its sides (3 to 8)."""

    def __init__(self, order=1, n=(2, 2, 2)):
        bend = None if order == 1 else lambda p: p + np.stack([0 * p[..., 0], 0 * p[..., 0], 0.1 * p[..., 0] ** 2], axis=-1)
        self.order = order
        self.points, triangles, self.cells = box(n, order=order, shape=bend)
        near = self.points[self.cells[:, :4], 0].mean(axis=1) < 0.5
        self.cells = np.concatenate([self.cells[near], self.cells[~near]])
        self.num_near = int(near.sum())
        self.surfaces = {name: triangles[k] for k, name in enumerate(SIDES)}
        self.names = {1: "near", 2: "far", **{3 + k: name for k, name in enumerate(SIDES)}}

    def elements(self):
        """(gmsh's type, group, nodes from 1) of all elements: triangles, then tetrahedra."""
        triangle, tetrahedron = (2, 4) if self.order == 1 else (9, 11)
        for k, name in enumerate(SIDES):
            for t in self.surfaces[name]:
                yield triangle, 3 + k, [int(n) + 1 for n in t]
        for c, cell in enumerate(self.cells):
            yield tetrahedron, 1 if c < self.num_near else 2, [int(n) + 1 for n in cell]

    def in_vtk_order(self):
        return [(kind, group, [nodes[i] for i in SWAPPED] if kind == 11 else nodes) for kind, group, nodes in self.elements()]


def lines(*rows):
    return ("\n".join(" ".join(map(str, row)) if isinstance(row, (list, tuple)) else str(row) for row in rows) + "\n").encode()


def msh(body):
    nodes = [(n + 1, *map(repr, map(float, p))) for n, p in enumerate(body.points)]
    elements = [(e + 1, kind, 2, group, group, *nodes_of) for e, (kind, group, nodes_of) in enumerate(body.elements())]
    names = [(3 if tag < 3 else 2, tag, f'"{name}"') for tag, name in body.names.items()]
    return lines("$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", len(names), *names, "$EndPhysicalNames", "$Nodes", len(nodes),
                 *nodes, "$EndNodes", "$Elements", len(elements), *elements, "$EndElements")


FACES = [(0, 1, 2), (0, 3, 1), (1, 3, 2), (2, 3, 0)]  # S1 to S4


def abaqus(body, parts=False):
    """Volumes as element sets; `left` as triangles, `right` as a node set, the others as surfaces."""
    def joined(row):
        return ", ".join(map(str, row))

    kind = "C3D4" if body.order == 1 else "C3D10"
    rows = ["*Heading", "a body", "** by hand", "*Part, name=Block" if parts else "**"]
    rows += ["*NODE", *(joined((n + 1, *map(repr, map(float, p)))) for n, p in enumerate(body.points))]
    triangles = [nodes for kind_, group, nodes in body.elements() if group == 3]
    number = 0
    rows.append(f"*Element, type={'S3' if body.order == 1 else 'STRI65'}, elset=left")
    for nodes in triangles:
        number += 1
        rows.append(joined((number, *nodes)))
    cells = {}
    rows.append(f"*Element, Type = {kind},\n elset=NEAR")
    for c, (_, _, nodes) in enumerate(e for e in body.in_vtk_order() if e[1] < 3):
        if c == body.num_near:
            rows.append(f"*ELEMENT, TYPE={kind}H")
        number += 1
        cells[number] = nodes
        row = joined((number, *nodes))
        rows.append(row if body.order == 1 else row[: row.rindex(",") + 1] + "\n " + row[row.rindex(",") + 1:])
    first = len(triangles) + body.num_near + 1
    rows += ["*Elset, elset=Far, generate", f"{first}, {number}, 1", "*Elset, elset=all", "near, FAR"]
    right = sorted({n for _, group, nodes in body.elements() if group == 4 for n in nodes})
    named = "" if not parts else ", instance=Block-1"
    if parts:
        rows += ["*End Part", "*Assembly, name=Assembly", "*Instance, name=Block-1, part=Block", "*End Instance", "*Node", "1, 9., 9., 9.",
                 "*Nset, nset=reference", "1,"]
    rows += [f"*Nset, nset=right{named}", *(joined(right[k: k + 16]) + "," for k in range(0, len(right), 16))]
    for tag, name in list(body.names.items())[4:]:
        facets = {frozenset(nodes[:3]) for _, group, nodes in body.elements() if group == tag}
        sides = [(number, side) for number, nodes in cells.items() for side in range(4)
                 if frozenset(nodes[i] for i in FACES[side]) in facets]
        for side in range(4):
            rows.append(f"*Elset, elset=_{name}_S{side + 1}, internal{named}")
            rows += [str(number) for number, s in sides if s == side] or []
        rows += [f"*Surface, type=ELEMENT, name={name}"]
        rows += [f"_{name}_S{side + 1}, S{side + 1}" for side in range(4) if any(s == side for _, s in sides)]
    rows += ["*End Assembly"] if parts else []
    rows += ["*Material, name=rubber", "*Elastic", "1e6, 0.4", "*Step", "*Static", "*Nset, nset=later", "77777", "*End Step"]
    return lines(*rows)


def medit(body):
    of_type = {}
    for kind, group, nodes in body.in_vtk_order():
        of_type.setdefault(kind, []).append((*nodes, group))
    titles = {2: "Triangles", 9: "TrianglesP2", 4: "Tetrahedra", 11: "TetrahedraP2"}
    rows = ["MeshVersionFormatted 2", "# by hand", "Dimension 3", "Vertices", len(body.points)]
    rows += [(*map(repr, map(float, p)), 0) for p in body.points]
    for kind, elements in of_type.items():
        rows += [titles[kind], len(elements), *elements]
    return lines(*rows, "Corners 2", "1 2", "End")


def nastran(body, fields="free"):
    rows = ["SOL 101", "CEND", "TITLE = a body", "BEGIN BULK", "$ by hand", "PSOLID,1,1"]

    def card(name, values):
        if fields == "free":
            for first in range(0, len(values), 8):
                rows.append(",".join([name if first == 0 else "+", *map(str, values[first: first + 8])]))
            return
        width, each = (16, 4) if fields == "large" else (8, 8)
        for first in range(0, len(values), each):
            mark = (name + "*" if width == 16 else name) if first == 0 else ("*" if width == 16 else "+")
            rows.append(f"{mark:8}" + "".join(f"{value!s:{width}}" for value in values[first: first + each]))

    def number(x):
        text = repr(float(x))
        if fields == "small":
            assert len(text) <= 8, text
        return text.replace("e-0", "-") if fields != "free" else text

    for n, p in enumerate(body.points):
        card("GRID", [n + 1, "", *(number(x) for x in p)])
    names = {2: "CTRIA3", 9: "CTRIA6", 4: "CTETRA", 11: "CTETRA"}
    for e, (kind, group, nodes) in enumerate(body.in_vtk_order()):
        card(names[kind], [e + 1, group, *nodes])
    return lines(*rows, "ENDDATA")


def unv(body):
    rows = ["    -1", "   164", "         1  SI: Metre (newton)         2", "    -1", "    -1", "  2411"]
    for n, p in enumerate(body.points):
        rows += [f"{n + 1:10}{1:10}{1:10}{11:10}", "".join(f"{float(x)!r:>25}".replace("e", "D") for x in p)]
    rows += ["    -1", "    -1", "  2412"]
    order = {2: [0, 1, 2], 4: [0, 1, 2, 3], 9: [0, 3, 1, 4, 2, 5], 11: [0, 4, 1, 5, 2, 6, 7, 9, 8, 3]}
    kinds, members = {2: 41, 9: 42, 4: 111, 11: 118}, {}
    for e, (kind, group, nodes) in enumerate(body.elements()):
        members.setdefault(group, []).append(e + 1)
        listed = [nodes[i] for i in order[kind]]
        rows.append("".join(f"{value:10}" for value in (e + 1, kinds[kind], 5, 1, 7, len(nodes))))
        rows += ["".join(f"{n:10}" for n in listed[first: first + 8]) for first in range(0, len(listed), 8)]
    rows += ["    -1", "    -1", "  2467"]
    for group, elements in members.items():
        rows += ["".join(f"{value:10}" for value in (group, 0, 0, 0, 0, 0, 0, len(elements))), body.names[group]]
        for first in range(0, len(elements), 2):
            rows.append("".join(f"{8:10}{e:10}{0:10}{0:10}" for e in elements[first: first + 2]))
    return lines(*rows, "    -1")


VTK_TYPES = {2: 5, 9: 22, 4: 10, 11: 24}


def vtk(body, binary=False, version="3.0"):
    elements = body.in_vtk_order()

    def array(values, kind):
        values = np.asarray(values)
        if binary:
            return values.astype(">" + {"int": "i4", "double": "f8", "vtktypeint64": "i8"}[kind]).tobytes() + b"\n"
        return lines(*(repr(v) for v in values.ravel().tolist()))

    out = lines(f"# vtk DataFile Version {version}", "a body", "BINARY" if binary else "ASCII", "DATASET UNSTRUCTURED_GRID",
                f"POINTS {len(body.points)} double") + array(body.points, "double")
    if version == "5.1":
        ends = np.cumsum([0] + [len(nodes) for _, _, nodes in elements])
        out += lines(f"CELLS {len(ends)} {ends[-1]}", "OFFSETS vtktypeint64") + array(ends, "vtktypeint64")
        out += lines("CONNECTIVITY vtktypeint64") + array([n - 1 for _, _, nodes in elements for n in nodes], "vtktypeint64")
    else:
        listed = [v for _, _, nodes in elements for v in (len(nodes), *(n - 1 for n in nodes))]
        out += lines(f"CELLS {len(elements)} {len(listed)}") + array(listed, "int")
    out += lines(f"CELL_TYPES {len(elements)}") + array([VTK_TYPES[kind] for kind, _, _ in elements], "int")
    out += lines(f"POINT_DATA {len(body.points)}", "VECTORS v double") + array(0 * body.points, "double")
    out += lines(f"CELL_DATA {len(elements)}", "SCALARS region int 1", "LOOKUP_TABLE default") + array([g for _, g, _ in elements], "int")
    return out + lines("FIELD FieldData 1", f"stiffness 1 {len(elements)} double") + array([float(g) for _, g, _ in elements], "double")


def vtu(body, form="ascii", header="UInt32", order="<"):
    """`form`: ascii, base64, zlib (base64), raw (appended), appended (base64), raw zlib (appended)."""
    elements, appended = body.in_vtk_order(), b""
    is_packed = "zlib" in form

    def encoded(data):
        head = order + ("I" if header == "UInt32" else "Q")
        if not is_packed:
            whole = struct.pack(head, len(data)) + data
            return whole if form == "raw" else base64.b64encode(whole)
        size = 200
        blocks = [zlib.compress(data[at: at + size]) for at in range(0, len(data), size)]
        start = b"".join(struct.pack(head, v) for v in (len(blocks), size, len(data) % size, *map(len, blocks)))
        return start + b"".join(blocks) if form == "raw zlib" else base64.b64encode(start) + base64.b64encode(b"".join(blocks))

    def array(name, values, kind, components=1):
        nonlocal appended
        values = np.asarray(values)
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}"'.encode()
        if form == "ascii":
            return head + b' format="ascii">\n' + lines(*map(repr, values.ravel().tolist())) + b"</DataArray>\n"
        data = values.astype(order + {"Int64": "i8", "Int32": "i4", "UInt8": "u1", "Float64": "f8"}[kind]).tobytes()
        if form in ("base64", "zlib"):
            return head + b' format="binary">\n' + encoded(data) + b"\n</DataArray>\n"
        head += f' format="appended" offset="{len(appended)}"/>\n'.encode()
        appended += encoded(data)
        return head

    packed = ' compressor="vtkZLibDataCompressor"' if is_packed else ""
    out = (f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{"Little" if order == "<" else "Big"}Endian" '
           f'header_type="{header}"{packed}>\n<!-- by hand -->\n<UnstructuredGrid>\n<Piece NumberOfPoints="{len(body.points)}" '
           f'NumberOfCells="{len(elements)}">\n<Points>\n').encode()
    out += array("Points", body.points, "Float64", 3) + b"</Points>\n<Cells>\n"
    out += array("connectivity", [n - 1 for _, _, nodes in elements for n in nodes], "Int64")
    out += array("offsets", np.cumsum([len(nodes) for _, _, nodes in elements]), "Int64")
    out += array("types", [VTK_TYPES[kind] for kind, _, _ in elements], "UInt8") + b"</Cells>\n<CellData>\n"
    out += array("material", [group for _, group, _ in elements], "Int32")
    out += array("stiffness", [float(group) for _, group, _ in elements], "Float64") + b"</CellData>\n</Piece>\n</UnstructuredGrid>\n"
    if appended:
        out += f'<AppendedData encoding="{"raw" if form.startswith("raw") else "base64"}">\n_'.encode() + appended + b"\n</AppendedData>\n"
    return out + b"</VTKFile>\n"


def write_med(body, path, mirrored=True):
    """As Salome does, with tetrahedra of opposite orientation; each group is a family."""
    mirror = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8] if mirrored else list(range(10))
    kinds = {2: "TR3", 9: "TR6", 4: "TE4", 11: "T10"}
    with h5py.File(path, "w") as file:
        file.create_group("INFOS_GENERALES").attrs.update({"MAJ": 4, "MIN": 0, "REL": 0})
        mesh = file.create_group("ENS_MAA/body")
        mesh.attrs.update({"DIM": 3, "ESP": 3})
        step = mesh.create_group("-0000000000000000001-0000000000000000001")
        step["NOE/COO"] = body.points.flatten(order="F")
        by_kind = {}
        for kind, group, nodes in body.in_vtk_order():
            if kind in (4, 11):
                nodes = [nodes[i] for i in mirror[: len(nodes)]]
            by_kind.setdefault(kinds[kind], []).append((group, nodes))
        for kind, elements in by_kind.items():
            step[f"MAI/{kind}/NOD"] = np.array([nodes for _, nodes in elements], dtype=np.int32).flatten(order="F")
            step[f"MAI/{kind}/FAM"] = np.array([-group for group, _ in elements], dtype=np.int32)
        file.create_group("FAS/body/FAMILLE_ZERO").attrs["NUM"] = 0
        for group, name in body.names.items():
            family = file.create_group(f"FAS/body/ELEME/FAM_{-group}_{name}")
            family.attrs["NUM"] = -group
            names = family.create_dataset("GRO/NOM", (1,), dtype="80int8")
            names[0] = np.frombuffer(name.encode().ljust(80, b"\0"), dtype=np.int8)


# Name of the file: its writer.
FILES = {
    "plain.inp": abaqus, "cae.inp": lambda body: abaqus(body, parts=True), "text.mesh": medit,
    "free.bdf": nastran, "large.nas": lambda body: nastran(body, "large"), "groups.unv": unv,
    "text.vtk": vtk, "binary.vtk": lambda body: vtk(body, binary=True), "text51.vtk": lambda body: vtk(body, version="5.1"),
    "binary51.vtk": lambda body: vtk(body, binary=True, version="5.1"), "text.vtu": vtu, "base64.vtu": lambda body: vtu(body, "base64"),
    "zlib.vtu": lambda body: vtu(body, "zlib", "UInt64"), "raw.vtu": lambda body: vtu(body, "raw", "UInt64"),
    "big.vtu": lambda body: vtu(body, "raw", order=">"), "appended.vtu": lambda body: vtu(body, "appended"),
    "raw_zlib.vtu": lambda body: vtu(body, "raw zlib"),
}


def write_all(directory, order):
    """Writes body.msh and all others; returns the names of the others."""
    body = Body(order)
    (directory / "body.msh").write_bytes(msh(body))
    for name, writer in FILES.items():
        (directory / name).write_bytes(writer(body))
    write_med(body, directory / "salome.med")
    write_med(body, directory / "same.med", mirrored=False)
    return [*FILES, "salome.med", "same.med"]
