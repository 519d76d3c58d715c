"""Damaged meshes of other programs, and what must be said of each; bad_meshes.py writes them with its own."""
import os
import pathlib
import re
import tempfile

import h5py

from other_formats import Body, abaqus, medit, nastran, unv, vtk, vtu, write_med


def cut(whole, part):
    return whole[: int(part * len(whole))]


BODY = Body()
INP, UNV, VTK, VTU, NAS, MEDIT = (abaqus(BODY), unv(BODY), vtk(BODY), vtu(BODY, "raw zlib"), nastran(BODY), medit(BODY))


def changed(whole, old, new):
    old, new = old.encode(), new.encode()
    assert whole.count(old) >= 1, old
    return whole.replace(old, new, 1)


# Name of the file: its contents, words of the message.
BAD = {
    "inp_nothing.inp": (b"hello\n", "ends without nodes"),
    "inp_cut.inp": (cut(INP, 0.3), "line [0-9]+: an element of type|incomplete|which the file does not define"),
    "inp_coordinate.inp": (changed(INP, "1, 0.0, 0.0, 0.0", "1, 0.0, O.0, 0.0"), "line 6: a coordinate is expected here, not 'O.0'"),
    "inp_twice.inp": (changed(INP, "\n2, ", "\n1, "), "line 7: node 1 is defined twice"),
    "inp_unknown_node.inp": (re.sub(rb"(type=C3D4[^\n]*\n[0-9]+, )[0-9]+", rb"\g<1>999999", INP, count=1, flags=re.I),
                             "refers to node 999999, which the file does not define"),
    "inp_twice_left_out.inp": (changed(INP, "*Elset, elset=all", "*Element, type=B31\n49, 1, 2\n*Elset, elset=all"),
                               "element 49 is defined twice"),
    "inp_no_such_set.inp": (changed(INP, "near, FAR", "near, FAT"), "the set 'FAT' is not defined before this line"),
    "inp_no_such_node.inp": (changed(INP, "*Nset, nset=right\n", "*Nset, nset=right\n88888,\n"),
                         "node set 'right' has node 88888, which the file does not define"),
    "inp_no_such_side.inp": (changed(INP, ", S1\n", ", S7\n"), r"surface '\w+' has the side 'S7' of a 4-node tetrahedron"),
    "inp_huge_range.inp": (changed(INP, "generate\n", "generate\n1, 9000000000000000000, 1\n"), "more numbers than the file has"),
    "inp_two_parts.inp": (changed(abaqus(BODY, parts=True), "*Assembly", "*Part, name=Other\n*End Part\n*Assembly"), "there is a second part"),
    "inp_moved.inp": (changed(abaqus(BODY, parts=True), "*End Instance", "0., 1., 0.\n*End Instance"), "translated or rotated"),
    "inp_itself.inp": (changed(INP, "** by hand", "*INCLUDE, INPUT=inp_itself.inp"), "files include one another endlessly"),
    "inp_missing.inp": (changed(INP, "** by hand", "*INCLUDE, INPUT=nowhere.inp"), "line 3: cannot include '.*nowhere.inp'"),
    "inp_hexahedra.inp": (changed(INP, "*Elset, elset=all", "*Element, type=C3D8R\n999, 1, 2, 3, 4, 5, 6, 7, 8\n*Elset, elset=all"),
                      "only tetrahedra of order 1 or 2 are supported"),
    "inp_binary.inp": (b"\x00\x01\x02" * 50, "not a text"),
    "vtk_nothing.vtk": (b"hello\n", "does not begin with"),
    "vtk_cut.vtk": (cut(VTK, 0.4), "line [0-9]+: .*(ends|expected|truncated)"),
    "vtk_cut_binary.vtk": (cut(vtk(BODY, True), 0.6), "byte [0-9]+|line [0-9]+"),
    "vtk_structured.vtk": (changed(VTK, "UNSTRUCTURED_GRID", "STRUCTURED_GRID"), "grids of other kinds"),
    "vtk_huge.vtk": (changed(VTK, "POINTS 27", "POINTS 2700000000000"), "truncated"),
    "vtk_point.vtk": (re.sub(rb"(CELLS 96 [0-9]+\n[0-9]+\s+)[0-9]+", rb"\g<1>777777", VTK), "it has point 777777, but there are only"),
    "vtk_size.vtk": (changed(VTK, "CELLS 96 ", "CELLS 96 4"), "ends|truncated|expected"),
    "vtu_nothing.vtu": (b"hello\n", "this is not XML"),
    "vtu_cut.vtu": (cut(VTU, 0.5), "truncated|damaged"),
    "vtu_cut_in_tags.vtu": (cut(VTU, 0.1), "line [0-9]+: .*truncated"),
    "vtu_lz4.vtu": (changed(VTU, "vtkZLib", "vtkLZ4"), "which is not supported: save it with ZLib or without"),
    "vtu_pieces.vtu": (changed(vtu(BODY), "</UnstructuredGrid>", "<Piece></Piece></UnstructuredGrid>"), "must be one piece"),
    "vtu_offset.vtu": (changed(VTU, 'offset="0"', 'offset="99999"'), "is not where its offset says"),
    "vtu_zlib.vtu": (VTU[:1500] + bytes(300) + VTU[1800:], "damaged|truncated"),
    "mesh_nothing.mesh": (b"hello\n", "does not begin with MeshVersionFormatted"),
    "mesh_cut.mesh": (cut(MEDIT, 0.8), "line [0-9]+: the file ends where"),
    "mesh_no_end.mesh": (changed(MEDIT, "\nEnd\n", "\n"), "without 'End'"),
    "mesh_vertex.mesh": (changed(MEDIT, "Tetrahedra\n48\n", "Tetrahedra\n48\n999 1 2 3 1\n"), "has vertex 999, but there are only 27"),
    "mesh_plane.mesh": (changed(MEDIT, "Dimension 3", "Dimension 2"), "three dimensions"),
    "bdf_nothing.bdf": (b"hello\n", "ends without nodes"),
    "bdf_cut.bdf": (cut(NAS, 0.8), "without ENDDATA|is expected in field|needs 4"),
    "bdf_system.bdf": (changed(NAS, "GRID,2,,", "GRID,2,5,"), "line [0-9]+: node 2 is in the coordinate system '5'"),
    "bdf_number.bdf": (changed(NAS, "GRID,2,,", "GRID,2,,x"), "a coordinate is expected in field 4 of GRID"),
    "bdf_node.bdf": (re.sub(rb"(CTETRA,49,1,)[0-9]+", rb"\g<1>777777", NAS), "777777, which the file does not define"),
    "unv_nothing.unv": (b"hello\n", "line 1: a dataset, which begins with -1, is expected"),
    "unv_cut.unv": (cut(UNV, 0.6), "line [0-9]+: .*(truncated|expected|needs)"),
    "unv_no_element.unv": (changed(UNV, "         8         1         0", "         7     99999         0"),
                       "line [0-9]+: a group has node 99999, which the file does not define"),
    "med_nothing.med": (b"hello\n", "not an HDF5 file"),
}


def med(change=None):
    """A whole MED file, or one changed by HDF5, as bytes."""
    with tempfile.TemporaryDirectory() as directory:
        path = pathlib.Path(directory) / "whole.med"
        write_med(BODY, path)
        if change is not None:
            with h5py.File(path, "a") as file:
                change(file)
        return path.read_bytes()


STEP = "ENS_MAA/body/-0000000000000000001-0000000000000000001/"


def reversed_families(file):
    del file[STEP + "MAI/TE4/FAM"]
    file[STEP + "MAI/TE4/FAM"] = [1, 2, 3]


def unknown_node(file):
    file[STEP + "MAI/TE4/NOD"][0] = 999


BAD |= {
    "med_cut.med": (cut(med(), 0.6), "truncated or damaged|crashed"),
    "med_other.med": (med(lambda file: file.__delitem__("ENS_MAA")), "has no ENS_MAA: it is not a MED file"),
    "med_families.med": (med(reversed_families), "its elements TE4 do not fit"),
    "med_node.med": (med(unknown_node), "refers to node 999, which the file does not define"),
    "med_plane.med": (med(lambda file: file["ENS_MAA/body"].attrs.__setitem__("ESP", 2)), "three dimensions"),
}


def write_all(directory):
    """Returns, for each, its name, its file in the directory and the pattern of the message."""
    for file, (content, _) in BAD.items():
        (directory / file).write_bytes(content)
    return [(os.path.splitext(file)[0] + " as " + os.path.splitext(file)[1], file, words) for file, (_, words) in BAD.items()]
