"""Writes a mesh with its groups as a gmsh file (4.1, text)."""
import numpy as np

from .mesh import EDGE, TRIANGLE_EDGES

# gmsh's types of elements: of linear ones, of quadratic ones, by dimension
TYPES = {False: (15, 1, 2, 4), True: (15, 8, 9, 11)}


def write(file, mesh, scale):
    """`scale`: of coordinates, which are written in metres."""
    points = (mesh.points_with_mids if mesh.quadratic else mesh.points) * scale
    used = np.unique(np.concatenate([mesh.cells.ravel(), *([mesh.mids.ravel()] if mesh.quadratic else [])]))
    number = np.zeros(len(points), dtype=np.int64)
    number[used] = np.arange(1, len(used) + 1)
    names, blocks = [], []  # (dimension, tag, name); (dimension, tags of groups, nodes)
    for dimension in (0, 1, 2, 3):
        groups = mesh.groups[dimension]
        tags = {name: len(names) + k + 1 for k, name in enumerate(groups)}
        names += [(dimension, tag, name) for name, tag in tags.items()]
        blocks += list(blocks_of(mesh, dimension, {tags[name]: np.concatenate(parts) for name, parts in groups.items()}))
    box = np.concatenate([points[used].min(axis=0), points[used].max(axis=0)])
    with open(file, "w", encoding="utf-8") as out:
        out.write(f"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n{len(names)}\n")
        out.writelines(f'{dimension} {tag} "{name}"\n' for dimension, tag, name in names)
        out.write("$EndPhysicalNames\n")
        write_entities(out, blocks, box)
        out.write(f"$Nodes\n1 {len(used)} 1 {len(used)}\n3 {last_volume(blocks)} 0 {len(used)}\n")
        out.writelines(f"{n}\n" for n in range(1, len(used) + 1))
        out.writelines("%.17g %.17g %.17g\n" % tuple(x) for x in points[used])
        out.write("$EndNodes\n")
        count = sum(len(nodes) for _, _, nodes in blocks)
        out.write(f"$Elements\n{len(blocks)} {count} 1 {count}\n")
        element = 0
        for entity, (dimension, _, nodes) in enumerate(blocks, 1):
            out.write(f"{dimension} {entity} {TYPES[mesh.quadratic][dimension]} {len(nodes)}\n")
            for row in number[nodes]:
                element += 1
                out.write(f"{element} {' '.join(map(str, row))}\n")
        out.write("$EndElements\n")


def last_volume(blocks):
    return len(blocks)  # volumes come last


def write_entities(out, blocks, box):
    counts = [sum(dimension == d for dimension, _, _ in blocks) for d in range(4)]
    out.write(f"$Entities\n{' '.join(map(str, counts))}\n")
    for entity, (dimension, tags, _) in enumerate(blocks, 1):
        place = box[:3] if dimension == 0 else box
        end = "" if dimension == 0 else " 0"
        out.write(f"{entity} {' '.join('%.9g' % x for x in place)} {len(tags)} {' '.join(map(str, tags))}{end}\n")
    out.write("$EndEntities\n")


def blocks_of(mesh, dimension, groups):
    """What has the same groups, together; groups may overlap. A volume without groups is left out."""
    if not groups:
        return
    if dimension == 3:
        members = {tag: np.unique(cells) for tag, cells in groups.items()}
        nodes = np.column_stack([mesh.cells, mesh.mids]) if mesh.quadratic else mesh.cells
    else:
        rows = {tag: np.atleast_2d(np.sort(cells.reshape(len(cells), -1), axis=1)) for tag, cells in groups.items()}
        nodes, back = np.unique(np.concatenate(list(rows.values())), axis=0, return_inverse=True)
        starts = np.cumsum([0] + [len(r) for r in rows.values()])
        members = {tag: np.unique(back[a:b]) for tag, a, b in zip(rows, starts, starts[1:])}
        if mesh.quadratic and dimension in (1, 2):
            nodes = np.column_stack([nodes, mesh.mids_of(nodes, TRIANGLE_EDGES if dimension == 2 else EDGE)])
    # A number for what groups a row has, of which a million may differ: the sum of random ones, one for each group.
    codes = np.random.default_rng(0).integers(1, 2**63, size=len(members), dtype=np.uint64)
    code = np.zeros(len(nodes), dtype=np.uint64)
    for own, rows_here in zip(codes, members.values()):
        code[rows_here] += own
    _, of = np.unique(code, return_inverse=True)
    tags_of = {}
    for tag, rows_here in members.items():
        for pattern in np.unique(of[rows_here]).tolist():
            tags_of.setdefault(pattern, []).append(tag)
    order = np.argsort(of, kind="stable")
    starts = np.searchsorted(of[order], np.arange(of.max() + 2))
    for pattern, tags in sorted(tags_of.items(), key=lambda item: item[1]):
        yield dimension, tags, nodes[order[starts[pattern]:starts[pattern + 1]]]
