"""Models of other programs as inputs: the command `pliant convert`.

`convert` is the command. `abaqus` and `febio` read the models, into a `model.Model` in the units of the model; `mesh` cuts its elements into
tetrahedra and names its groups, `msh` writes them, `input_text` writes the input. What has no place in an input goes to
`model.Diagnostics`: nothing is dropped in silence.
"""
