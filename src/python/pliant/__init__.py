"""Pliant from Python: runs simulations, drives them step by step, and reads what they leave on disk into numpy.

    import pliant
    run = pliant.run("input/beam_small.yaml", {"time.end": "50 ms"}, output="out/beam")
    print(run.history["kinetic_energy"][-1], run.result[-1].displacement().max())

All numbers are in SI units.
"""
from .checkpoint import Checkpoint
from .error import InputError, PliantError, SolveError
from .history import History
from .parts import Field, Joint, Line, Mechanisms, Mesh, MeshGroup, Obstacles, von_mises
from .result import Frame, Result
from .runs import Run, resume, run
from .simulation import NamedSurface, SavedState, Simulation
from .studies import Fit, Gradient, Modes, Sensitivity, fit, gradient, modes, sensitivity
from .surface import Surface

__all__ = ["Checkpoint", "Field", "Fit", "Frame", "Gradient", "History", "InputError", "Joint", "Line", "Mechanisms", "Mesh", "MeshGroup", "Modes",
           "NamedSurface", "Obstacles", "PliantError", "Result", "Run", "SavedState", "Sensitivity", "Simulation", "SolveError", "Surface",
           "fit", "gradient", "modes", "resume", "run", "sensitivity", "von_mises"]
