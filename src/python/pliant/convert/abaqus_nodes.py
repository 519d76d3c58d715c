"""Displacements and forces that an input file of Abaqus or CalculiX gives nodes.

Both programs keep them by node: what a step gives a node replaces what it had, by whatever name the node was given.
"""


class NodeTable:
    """The function of time of each component of nodes. A target is the name of a set of nodes, or the row of a node."""

    def __init__(self, model):
        self.model = model
        self.course = {}  # (row, component) -> Course
        self.said = {}  # (target, component) -> courses that were given, the last one last

    def rows(self, target):
        return list(dict.fromkeys(self.model.node_sets[target])) if isinstance(target, str) else [target]

    def set(self, target, component, rows, course):
        self.course.update({(row, component): course for row in rows})
        courses = self.said.pop((target, component), {})  # the latest comes last
        courses.pop(course, None)
        self.said[target, component] = {**courses, course: None}

    def by_target(self):
        """(target, component, course, rows) of what holds in the end; rows are all nodes of the target, or some of them."""
        for (target, component), courses in self.said.items():
            for course in courses:
                rows = [row for row in self.rows(target) if self.course.get((row, component)) == course]
                if rows:
                    yield target, component, course, rows

    def of_node(self, row):
        """The functions of time of a node by component."""
        return {c: self.course[row, c] for c in range(6) if (row, c) in self.course}

    def remove(self, rows):
        """Forgets those of nodes."""
        for row in rows:
            for c in range(6):
                self.course.pop((row, c), None)
