#!/usr/bin/python3
"""Meshes that are damaged or of another kind, and what must be said of each: file (and line, where the format has lines), what is wrong
and what helps.

  tests/mesh/bad_meshes.py DIRECTORY      writes them all, and cases.txt: a line for each, with file and pattern

The tests of the layer read all of them on any number of ranks; those of the program run a few.
"""
import os
import pathlib
import re
import struct
import sys

import h5py
import numpy as np

import bad_formats
from bricks import TETRAHEDRON, Brick, write_parts

TRIANGLE_6, TETRAHEDRON_10, HEXAHEDRON, PRISM, PYRAMID, TETRAHEDRON_20 = 9, 11, 5, 6, 7, 29  # gmsh's element types
CURE = r"write or copy it again|write it again"


def brick(change=None):
    result = Brick()
    if change is not None:
        change(result)
    return result


def text(change=None):
    return brick(change).msh2()


def replaced(old, new, source=None):
    good = text() if source is None else source
    assert good.count(old) >= 1, old
    return good.replace(old, new, 1)


def other_cells(kind, num_nodes):
    """A volume of one other element beside the tetrahedra."""
    def change(b):
        b.blocks.insert(0, (3, 8, kind, 7, [list(range(1, num_nodes + 1))]))
    return text(change)


def moved(tag, place):
    def change(b):
        b.points[tag - 1] = place
    return change


def reuse(old, new):
    """The first cell with a node `old` has `new` instead."""
    def change(b):
        cell = next(c for c in b.cells() if old in c)
        cell[cell.index(old)] = new
    return change


def drop_node(b):
    del b.tags[13], b.points[13]


def only_triangles(b):
    b.blocks.pop()


def flat(b):
    b.blocks.pop()
    b.points = [(x, y, 0.0) for x, y, _ in b.points]


def second_order_beside_first(b):
    b.blocks.append((3, 9, TETRAHEDRON_10, 7, [list(range(1, 11))]))


def two_quadratic_cells():
    """They share a facet, but not the nodes in the middle of its edges."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.0]])
    points, cells = list(corners), []
    for number, cell in enumerate(((0, 1, 2, 3), (1, 2, 3, 4))):
        first = len(points)
        points += [corners[[cell[a], cell[b]]].mean(axis=0) + 0.01 * number for a, b in ((0, 1), (1, 2), (2, 0), (3, 0), (3, 2), (3, 1))]
        cells.append([*cell, *range(first, first + 6)])
    nodes = "".join(f"{n + 1} {x:.17g} {y:.17g} {z:.17g}\n" for n, (x, y, z) in enumerate(points))
    elements = "".join(f"{c + 1} {TETRAHEDRON_10} 2 1 1 {' '.join(str(n + 1) for n in cell)}\n" for c, cell in enumerate(cells))
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(points)}\n{nodes}$EndNodes\n"
            f"$Elements\n{len(cells)}\n{elements}$EndElements\n").encode()


def partitioned(held, num_partitions):
    """Version 4.1 as gmsh writes it into a file for each partition, which names only the volumes that it holds."""
    volumes = "".join(f"{100 + p} 3 7 1 {p} 0 0 0 1 1 1 1 7 0\n" for p in held)
    section = f"$PartitionedEntities\n{num_partitions}\n0\n0 0 0 {len(held)}\n{volumes}$EndPartitionedEntities\n".encode()
    return replaced(b"$Nodes", section + b"$Nodes", Brick().msh4())


def wrong_number(key, wrong):
    """The first number after `key` in the text of version 2.2 or 4.1."""
    return lambda source: re.sub(b"(" + key + rb"\n)\S+", lambda m: m[1] + wrong, source, count=1)


def swapped_marker(source):
    """The byte order says the opposite of what follows."""
    at = source.index(b"\n", source.index(b"$MeshFormat\n") + 12) + 1
    return source[:at] + source[at : at + 4][::-1] + source[at + 4 :]


def numbers_at(key, skip, new):
    """Bytes behind the first line `key`, and `skip` more, replaced in a binary file."""
    def change(source):
        at = source.index(key) + len(key) + skip
        return source[:at] + new + source[at + len(new) :]
    return change


# Name: (name of the file, its bytes, words of the message). '@LINE ' stands before what the message must find in that line.
BAD = {
    "empty": ("a.msh", b"", "empty"),
    "blank": ("a.msh", b"\n \n\t\n", r"without a \$Nodes"),
    "zeros": ("a.msh", bytes(5000), r"begin with \$MeshFormat"),
    "a picture": ("a.msh", b"\x89PNG\r\n\x1a\n" + bytes(range(256)), r"begin with \$MeshFormat"),
    "packed": ("a.msh", b"\x1f\x8b\x08\x00" + bytes(range(200)), r"begin with \$MeshFormat"),
    "another mesher's": ("a.msh", b"(0 \"FLUENT\")\n(2 3)\n", r"begin with \$MeshFormat"),
    "a name without an ending": ("mesh", text(), "extension .*meshes are .msh, .inp"),
    "a name of another ending": ("a.ply", text(), "extension .*meshes are .msh, .inp"),
    "version 1": ("a.msh", b"$NOD\n1\n1 0 0 0\n$ENDNOD\n", "2.2 or 4.1"),
    "version 3": ("a.msh", replaced(b"2.2 0 8", b"3.0 0 8"), "line 2: version 3 .*convert it: gmsh"),
    "version 4.0": ("a.msh", replaced(b"2.2 0 8", b"4.0 0 8"), "line 2: version 4 .*convert it: gmsh"),
    "a version of words": ("a.msh", replaced(b"2.2 0 8", b"new 0 8"), "line 2: the version"),
    "single precision": ("a.msh", replaced(b"2.2 0 8", b"2.2 0 4"), "line 2: the data size"),
    "text said binary": ("a.msh", replaced(b"2.2 0 8", b"2.2 1 8"), "byte order is wrong: .*" + CURE),
    "binary said text": ("a.msh", Brick().msh2(binary=True).replace(b"2.2 1 8", b"2.2 0 8"), "line 3: "),
    "binary 4.1 said text": ("a.msh", Brick().msh4(binary=True).replace(b"4.1 1 8", b"4.1 0 8"), "line 3: "),
    "4.1 said 2.2": ("a.msh", Brick().msh4().replace(b"4.1 0 8", b"2.2 0 8"), "line [0-9]+: "),
    "2.2 said 4.1": ("a.msh", Brick().msh2().replace(b"2.2 0 8", b"4.1 0 8"), "line [0-9]+: "),
    "byte order against the bytes": ("a.msh", swapped_marker(Brick().msh2(binary=True)), "byte [0-9]+: "),
    "byte order against the bytes of 4.1": ("a.msh", swapped_marker(Brick().msh4(binary=True)), "byte [0-9]+: "),
    "byte order of neither kind": ("a.msh", numbers_at(b"2.2 1 8\n", 0, b"\7\7\7\7")(Brick().msh2(binary=True)), "byte order is wrong"),
    "a node that is no number": ("a.msh", text(moved(5, (float("nan"), 0.5, 0.0))), "not finite .*node 5; mesh"),
    "an infinite node": ("a.msh", text(moved(5, (0.5, float("-inf"), 0.0))), "not finite .*node 5; mesh"),
    "a node out of this world": ("a.msh", text(moved(5, (0.5, 1e300, 0.0))), "beyond 1e100.* node 5; mesh"),
    "a node that is no number, in bytes": ("a.msh", brick(moved(5, (float("nan"), 0.5, 0.0))).msh4(binary=True), "not finite .*node 5;"),
    "a word for a coordinate": ("a.msh", replaced(b"\n5 0.5", b"\n5 @LINE half"), "a coordinate is expected here, not 'half'"),
    "a coordinate too few": ("a.msh", replaced(b"\n5 0.5 0.5 0.0\n6", b"\n5 0.5 0.5\n@LINE 6"), "the number of a node is expected here"),
    "a comma for a point": ("a.msh", replaced(b"\n5 0.5 0.5", b"\n5 @LINE 0,5 0.5"), "not '0,5'"),
    "a flat cell": ("a.msh", text(lambda b: b.cells()[7].__setitem__(0, b.cells()[7][1])), "without volume: element 56; remesh"),
    "nodes in one plane": ("a.msh", text(moved(14, (0.4, 0.3, 0.0))), "without volume: .*remesh"),
    "a node pulled through": ("a.msh", text(moved(14, (3.0, 0.5, 0.5))), "overlap .*remesh"),
    "nodes at one place": ("a.msh", text(lambda b: (b.tags.append(28), b.points.append(b.points[13]), reuse(14, 28)(b))),
                           "coincide with another node: .*Join them in gmsh"),
    "a cell twice": ("a.msh", text(lambda b: b.cells().append(list(b.cells()[0]))), "duplicate tetrahedra .*delete one"),
    "a volume of two groups in 2.2": ("a.msh", text(lambda b: b.blocks.append((3, 8, TETRAHEDRON, 8, b.cells()[:5]))),
                                      "duplicate tetrahedra .*version 4.1"),
    "one partition of two": ("a.msh", partitioned({1}, 2), r"line [0-9]+: the file holds 1 of a mesh's 2 partitions; write the whole"),
    "partitions in disorder": ("a.msh", replaced(b"$PartitionedEntities\n2", b"$PartitionedEntities\n@LINE two", partitioned({1, 2}, 2)),
                               "the number of partitions is expected here, not 'two'"),
    "three cells at a facet": ("a.msh", text(lambda b: (b.tags.append(28), b.points.append((0.1, 0.2, 0.15)),
                                                        b.cells().append(b.cells()[0][:3] + [28]))), "facet"),
    "a node twice": ("a.msh", text(lambda b: b.tags.__setitem__(5, 5)), "node 5 is defined twice: give"),
    "a node missing": ("a.msh", text(drop_node), "node 14, which the file does not define: write"),
    "a node missing, in bytes": ("a.msh", brick(drop_node).msh4(binary=True), "node 14, which the file does not define: write"),
    "a negative node": ("a.msh", text(reuse(14, -14)), "a node of an element is expected here, not '-14'"),
    "a node beyond counting": ("a.msh", text(reuse(14, 99999999999)), "a node of an element is expected here, not '99999999999'"),
    "counts of 1e18 nodes": ("a.msh", wrong_number(rb"\$Nodes", b"1000000000000000000")(text()), "line [0-9]+: .*bytes follow.*" + CURE),
    "counts of 1e30 nodes": ("a.msh", wrong_number(rb"\$Nodes", b"1" + b"0" * 30)(text()), "line [0-9]+: the number of nodes"),
    "counts of -1 nodes": ("a.msh", wrong_number(rb"\$Nodes", b"-1")(text()), "number of nodes is -1"),
    "counts of 0 nodes": ("a.msh", wrong_number(rb"\$Nodes", b"0")(text()), r"\$EndNodes is expected here"),
    "a node too many": ("a.msh", wrong_number(rb"\$Nodes", b"26")(text()), r"\$EndNodes is expected here"),
    "a node too few": ("a.msh", wrong_number(rb"\$Nodes", b"28")(text()), r"not '\$EndNodes'"),
    "an element too many": ("a.msh", wrong_number(rb"\$Elements", b"3")(text()), r"\$EndElements is expected here|a section .* is expected here"),
    "counts of 1e18 elements": ("a.msh", wrong_number(rb"\$Elements", b"1000000000000000000")(text()), "line [0-9]+: .*" + CURE),
    "counts of 1e18 nodes in 4.1": ("a.msh", re.sub(rb"\$Nodes\n1 27", b"$Nodes\n1 1000000000000000000", Brick().msh4()), CURE),
    "counts of 1e18 blocks in 4.1": ("a.msh", re.sub(rb"\$Elements\n7", b"$Elements\n1000000000000000000", Brick().msh4()), CURE),
    "counts of 2^62 nodes, in bytes": ("a.msh", numbers_at(b"$Nodes\n", 8, struct.pack("<Q", 1 << 62))(Brick().msh4(binary=True)), CURE),
    "counts of 2^64 - 1 nodes, in bytes": ("a.msh", numbers_at(b"$Nodes\n", 8, b"\xff" * 8)(Brick().msh4(binary=True)), CURE),
    "counts of 2^64 - 1 entities, in bytes": ("a.msh", numbers_at(b"$Entities\n", 16, b"\xff" * 8)(Brick().msh4(binary=True)), CURE),
    "counts of -1 elements, in bytes": ("a.msh", numbers_at(b"$Elements\n96\n", 4, b"\xff" * 4)(Brick().msh2(binary=True)), CURE),
    "a type of element there is none": ("a.msh", numbers_at(b"$Elements\n96\n", 0, b"\xff" * 4)(Brick().msh2(binary=True)), "type -1"),
    "blocks against their sum": ("a.msh", re.sub(rb"3 7 0 27", b"3 7 0 26", Brick().msh4()), "line [0-9]+: "),
    "an entity of four dimensions": ("a.msh", re.sub(rb"3 7 0 27", b"4 7 0 27", Brick().msh4()), "dimension of an entity must be"),
    "blocks of elements against their sum": ("a.msh", re.sub(rb"(\$Elements\n7) 96", rb"\1 97", Brick().msh4()), "hold 96 elements, but the section says 97"),
    "a block of more elements than there are": ("a.msh", wrong_number(rb"\$Elements", b"41")(Brick().msh2(binary=True)), "do not add up"),
    "cells on a surface": ("a.msh", Brick().msh4().replace(b"3 7 4 48", b"2 7 4 48"), "in an entity of dimension 2"),
    "sections in disorder": ("a.msh", text()[: text().index(b"$Nodes")] + text()[text().index(b"$Elements") :] +
                             text()[text().index(b"$Nodes") : text().index(b"$Elements")], "elements come before the nodes"),
    "nodes of two meshes": ("a.msh", text() + text()[text().index(b"$Nodes") : text().index(b"$Elements")], r"second \$Nodes"),
    "two meshes in a file": ("a.msh", text() + text(), r"second \$"),
    "words after the end": ("a.msh", text() + b"the end\n", "a section .*is expected here"),
    "a section without end": ("a.msh", text() + b"$Comments\nthe end\n", r"inside \$Comments.*" + CURE),
    "a section of an endless name": ("a.msh", text() + b"$" + b"x" * 100000, r"inside \$x{20,40}\.\.\."),
    "hexahedra": ("a.msh", other_cells(HEXAHEDRON, 8), "1 of type 8-node hexahedron; in gmsh use no Recombine"),
    "pyramids": ("a.msh", other_cells(PYRAMID, 5), "5-node pyramid; in gmsh"),
    "prisms": ("a.msh", other_cells(PRISM, 6), "6-node prism; in gmsh"),
    "cubic tetrahedra": ("a.msh", other_cells(TETRAHEDRON_20, 20), "order 1 or 2"),
    "orders one and two": ("a.msh", text(second_order_beside_first), "mixes first- and second-order .*mesh all volumes"),
    "cells that meet at other middle nodes": ("a.msh", two_quadratic_cells(), "disagree with a neighbour on the mid-edge node.*element 2; mesh all"),
    "a surface alone": ("a.msh", text(only_triangles), "contains no tetrahedra, only 48 of type 3-node triangle.*a Volume"),
    "a mesh in two dimensions": ("a.msh", text(flat), "contains no tetrahedra.*a Volume"),
    "nodes alone": ("a.msh", text(lambda b: b.blocks.clear()), "contains no tetrahedra, only nodes.*a Volume"),
    "a name of two groups": ("a.msh", text(lambda b: b.names.append((2, 9, "left"))), "have the name 'left': give each"),
    "a name without its quotes": ("a.msh", replaced(b'"body"', b'body'), "line [0-9]+: .*in double quotes"),
    "a name without its end": ("a.msh", replaced(b'"right"', b'"right'), "line [0-9]+: the name .*rename it"),
    "a name with a control character": ("a.msh", replaced(b'"right"', b'"ri\x1fght"'), "line [0-9]+: the name .*rename it"),
    "a group of four dimensions": ("a.msh", replaced(b'3 7 "body"', b'4 7 "body"'), "dimension of a physical group must be"),
    "a group's number too large": ("a.msh", replaced(b" 4 2 7 7 ", b" 4 2 -2147483648 7 "), "tag of an element is too large"),
    "geometry with a misspelt command": ("a.geo", b"SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\nPhisical Volume(1) = {1};\n",
                                         "line 3"),
    "geometry that ends early": ("a.geo", b"SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1,", "gmsh could not"),
    "geometry without a volume": ("a.geo", b"SetFactory(\"OpenCASCADE\");\nRectangle(1) = {0, 0, 0, 1, 1};\n", "no tetrahedra.*a Volume"),
    "geometry of a box without thickness": ("a.geo", b"SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 0};\n", "gmsh could not|no tetr"),
    "geometry of nothing": ("a.geo", b"", "empty"),
    "geometry of a remark": ("a.geo", b"// later\n", "no tetrahedra.*a Volume"),
    "geometry that leaves": ("a.geo", b"Exit;\n", "remove its Exit"),
    "geometry that runs a program": ("a.geo", b'SystemCall "kill -9 $PPID";\n', "line 1, column 1: 'SystemCall' runs a program"),
    "geometry of elements of order six": ("a.geo", b"SetFactory(\"OpenCASCADE\");\nBox(1) = {0, 0, 0, 1, 1, 1};\nMesh.MeshSizeMin = 1;\nMesh.ElementOrder = 6;\n",
                                     "set Mesh.ElementOrder to 1 or 2|order 1 or 2"),
    "geometry that includes what is missing": ("a.geo", b'Include "missing.geo";\n', "gmsh could not"),
    "geometry of bytes": ("a.geo", bytes(range(1, 256)) * 4, "gmsh could not"),
    "a drawing that is none": ("a.step", b"just text\n", "gmsh could not|no solid"),
    "a drawing cut short": ("a.step", b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nENDSEC;\nDATA;\n#1=CARTES", "gmsh could not|no solid"),
    "a drawing of bytes": ("a.stp", bytes(range(256)) * 8, "gmsh could not|no solid"),
    "a shape that is none": ("a.brep", b"just text\n", "truncated or damaged"),
    "a scan that is none": ("a.stl", b"just text\n", "no triangles|gmsh could not"),
    "a scan with a hole": ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                           b"endsolid a\n", "not closed"),
    "parts of bytes": ("a.h5", bytes(range(256)) * 8, "not an HDF5 file"),
    "parts of nothing": ("a.h5", b"", "empty"),
}
for form, whole in {"2.2": Brick().msh2(), "2.2 in bytes": Brick().msh2(binary=True), "4.1": Brick().msh4(),
                    "4.1 in bytes": Brick().msh4(binary=True)}.items():
    for part in (0.03, 0.2, 0.5, 0.8):
        BAD[f"{form} cut at {part}"] = ("a.msh", whole[: int(part * len(whole))], r"(line|byte) [0-9]+: |without a \$")
    BAD[f"{form} cut before its end"] = ("a.msh", whole[: whole.rindex(b"$EndElements") + 4], "line [0-9]+: .*" + CURE)


def attribute(path, name, value):
    def change(file):
        file[path].attrs[name] = value
    return change


def dataset(path, values, **more):
    def change(file):
        attributes = dict(file[path].attrs) if path in file else {}
        if path in file:
            del file[path]
        made = file.create_dataset(path, data=values, **more)
        made.attrs.update(attributes)
    return change


def never_written(path, shape, kind):
    """Sizes that no bytes stand behind."""
    def change(file):
        attributes = dict(file[path].attrs)
        del file[path]
        file.create_dataset(path, shape=shape, dtype=kind, chunks=(1024, shape[1])).attrs.update(attributes)
    return change


NODES = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1], [1, 1, 0.0]]
# Name: what is done to a good mesh in parts, words of the message.
BAD_PARTS = {
    "another format": (attribute("/", "format", np.bytes_("mine")), "not a mesh of Pliant: make one"),
    "a format of numbers": (attribute("/", "format", 7), CURE + "|make one"),
    "a later version": (attribute("/", "version", 2), "version 2 .*" + CURE),
    "a version of words": (attribute("/", "version", np.bytes_("one")), CURE),
    "no nodes": (lambda f: f.__delitem__("nodes"), "contains no nodes"),
    "no cells": (lambda f: f.__delitem__("cells"), "contains no cells"),
    "nodes in the plane": (dataset("nodes", np.array(NODES)[:, :2]), "rows of 3 numbers"),
    "nodes in a row": (dataset("nodes", np.array(NODES).ravel()), "rows of 3 numbers"),
    "whole nodes": (dataset("nodes", np.array(NODES, dtype=int)), "floating-point numbers"),
    "words for nodes": (dataset("nodes", np.array([b"a", b"b"])), "floating-point numbers"),
    "one number for nodes": (dataset("nodes", 3.0), "rows of 3 numbers"),
    "broken cells": (dataset("cells", np.array([[0, 1, 2, 3.5]] * 3)), "integers"),
    "a node that is no number": (dataset("nodes", np.array(NODES[:-1] + [[1, float("nan"), 0]])), "not finite .*row 5"),
    "a cell of unknown nodes": (dataset("cells", np.array([[0, 1, 2, 3], [1, 2, 3, 6], [1, 5, 2, 4]], dtype=np.int32)), "row 1 of cells"),
    "a cell of negative nodes": (dataset("cells", np.array([[0, 1, 2, 3], [-1, 2, 3, 4], [1, 5, 2, 4]], dtype=np.int32)), "row 1 of cells"),
    "a cell of huge nodes": (dataset("cells", np.array([[0, 1, 2, 3], [1 << 40, 2, 3, 4], [1, 5, 2, 4]])), "row 1 of cells"),
    "a cell of a node twice": (dataset("cells", np.array([[0, 1, 2, 3], [2, 2, 3, 4], [1, 5, 2, 4]], dtype=np.int32)), "row 1 of cells"),
    "a cell turned round": (dataset("cells", np.array([[0, 1, 2, 3], [2, 1, 3, 4], [1, 5, 2, 4]], dtype=np.int32)), "inverted or flat"),
    "no cells at all": (dataset("cells", np.zeros((0, 4), dtype=np.int32)), "0 tetrahedra"),
    "nodes without bytes": (never_written("nodes", (1 << 28, 3), "f8"), "of them: the file is truncated or damaged"),
    "nodes beyond counting": (never_written("nodes", (1 << 60, 3), "f8"), "too many for 32-bit indices|truncated"),
    "cells beyond counting": (never_written("cells", (1 << 59, 4), "i4"), "too many for 32-bit indices|truncated"),
    "members beyond counting": (never_written("groups/0", (1 << 59, 2), "i8"), "of them: the file is truncated or damaged"),
    "a member of no cell": (dataset("groups/0", np.array([[7, 1]])), "'left' has a member that is not part of any cell"),
    "a member of no facet": (dataset("groups/0", np.array([[0, 4]])), "'left' has a member that is not part of any cell"),
    "members in a row": (dataset("groups/0", np.array([0, 1])), "rows of 2 numbers"),
    "a group without a name": (lambda f: f["groups/0"].attrs.__delitem__("name"), CURE),
    "a group of four dimensions": (attribute("groups/0", "dimension", 4), "dimension of a group must be"),
    "a group's number too large": (attribute("groups/0", "tag", 1 << 40), "too large"),
    "a group's name of two lines": (attribute("groups/0", "name", np.bytes_("left\x1f2")), "rename it"),
    "data of other cells": (lambda f: f.create_dataset("cell_data/0", data=np.zeros((4, 1))).attrs.update({"name": np.bytes_("a")}),
                            "a row of 1 to 9 numbers for each cell"),
}


def cut(part):
    def change(path):
        whole = path.read_bytes()
        path.write_bytes(whole[: int(part * len(whole))])
    return change


def cut(path, part):
    whole = path.read_bytes()
    path.write_bytes(whole[: int(part * len(whole))])


def as_file(name):
    return re.sub(r"\W+", "_", name)


def write_all(directory):
    """Returns, for each, its name, its file in the directory and the pattern of the message."""
    cases = bad_formats.write_all(directory)
    for name, (kind, content, words) in BAD.items():
        file = as_file(name) + os.path.splitext(kind)[1]
        if b"@LINE " in content:
            line = content[: content.index(b"@LINE ")].count(b"\n") + 1
            content, words = content.replace(b"@LINE ", b""), rf"line {line}: .*(?:{words})"
        (directory / file).write_bytes(content)
        cases.append((name, file, words))
    for name, (change, words) in BAD_PARTS.items():
        file = "parts_" + as_file(name) + ".h5"
        write_parts(directory / file, change)
        cases.append(("parts: " + name, file, words))
    for part in (0.1, 0.5, 0.99):
        file = f"parts_cut_at_{part}.h5"
        write_parts(directory / file)
        cut(directory / file, part)
        cases.append((f"parts cut at {part}", file, CURE + "|its beginning is damaged"))
    return cases


if __name__ == "__main__":
    where = pathlib.Path(sys.argv[1])
    (where / "cases.txt").write_text("".join(f"{file}\t{words}\n" for _, file, words in write_all(where)))
