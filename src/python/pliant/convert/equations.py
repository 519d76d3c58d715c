"""Linear equations between nodes as constraints of the input."""
from .forces import new_name


def equation_entries(model, mesh, diagnostics):
    """Entries of `constraints`, with a group for each node at a corner of elements, and a box around each other one."""
    if not model.equations:
        return []
    corners = set(mesh.corners_among(range(len(model.points))).tolist())
    places = {}
    for terms, _ in model.equations:
        for row, _, _ in terms:
            if row not in places:
                places[row] = {"point": mesh.name_points(new_name(mesh, "node"), [row])} if row in corners else {"box": mesh.box_around(row)}
    if not mesh.is_linear_only and not mesh.quadratic:
        diagnostics.note(None, f"{len(model.equations)} equations hold at the nodes of the model alone, and not at the middle of edges, where element: P2 adds nodes; between two "
                         "surfaces whose meshes are copies, periodic_with holds everywhere")
    return [{"name": f"equation_{k}", "equation": [{**places[row], "component": "xyz"[c], "coefficient": coefficient} for row, c, coefficient in terms],
             **({} if value is None else {"value": value})} for k, (terms, value) in enumerate(model.equations, 1)]
