#!/usr/bin/python3
"""A user's mistake ends the program, on any number of ranks alike, with one message that names the place and helps."""
import itertools
import os
import pathlib
import re
import resource
import subprocess
import sys
import unittest

import h5py
import numpy as np

from mistakes import MistakesTest
from program import ENVIRONMENT, LINE, PROGRAM, UNSIGNALLED, box, finish, long_test, start, write_box, write_mesh

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "mesh"))

from bricks import Brick  # noqa: E402

LINES = {
    "mesh": "mesh: {file: cube.msh}",
    "bodies": "bodies: [{density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}}]",
    "constraints": "constraints: [{surface: left, displacement: [0, 0, 0]}]",
    "loads": "loads: [{gravity: [0, 0, -9.81]}]",
    "time": "time: {step: 0.01, end: 0.02}",
    "output": "output: {directory: out}",
}
LAW = "density: 1000, elasticity: {model: neo-hookean, youngs_modulus: 1e6, poissons_ratio: 0.4}"

# Mistakes that the input alone tells; every rank reads it alike.
# Name: line of the good input that is replaced, its replacement ('@' stands before the place that the message must
# name), words of the message.
BAD_LINES = {
    "unknown key": ("bodies", "bodies: [{density: 1, elasticity: {model: linear, @youngs_modulos: 1, poissons_ratio: 0}}]",
                    "did you mean 'youngs_modulus'"),
    "unknown section": ("output", "@constrains: []", "did you mean 'constraints'"),
    "contact with nothing": ("output", "contact: @{law: penalty}", "at least one of pairs, obstacles is needed"),
    "wrong unit": ("time", "time: {step: @5 mm, end: 1}", "5 mm"),
    "no such unit": ("time", "time: {step: @5 flops, end: 1}", "flops"),
    "not a number": ("bodies", "bodies: [{density: @heavy, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
                     "heavy"),
    "Poisson's ratio": ("bodies", "bodies: [{density: 1, elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: @0.6}}]",
                        "0.6"),
    "unknown law": ("bodies", "bodies: [{density: 1, elasticity: {model: @neohookean, youngs_modulus: 1, poissons_ratio: 0}}]",
                    "did you mean 'neo-hookean'"),
    "a key of another viscosity": ("bodies", "bodies: [{" + LAW + ", viscosity: {model: maxwell, shear_modulus: 1, "
                                   "relaxation_time: 1, @shear: 1}}]", "only be given with 'model: kelvin-voigt'"),
    "a viscosity without its parameter": ("bodies", "bodies: [{" + LAW + ", viscosity: @{model: kelvin-voigt}}]",
                                          "missing key 'shear'"),
    "pressure as a vector": ("loads", "loads: [{surface: top, pressure: @[0, 0, 1]}]", "'pressure' must be a pressure"),
    "pressure on nothing": ("loads", "loads: [@{pressure: 2 kPa}]", "surface, box, where"),
    "unknown method": ("time", "time: {method: @bdf22, step: 0.01, end: 1}", "did you mean 'bdf2'"),
    "method of other programs": ("time", "time: {method: @newmark, step: 0.01, end: 1}", "not 'newmark' .for motion: 'bdf2'"),
    "integrator that PETSc does not have": ("time", "time: {method: {petsc: @rk}, step: 0.01, end: 1}", "alpha2, bdf, arkimex"),
    "coefficients that are no method": ("time", "time: {method: @{A: [[0.5]], b: [0.9]}, step: 0.01, end: 1}", "inconsistent"),
    "adaptive steps of a symplectic method": ("time", "time: {method: implicit-midpoint, end: 1, adaptive: @{}}", "symplectic"),
    "event after the end": ("time", "time: {step: 0.01, end: 1, events: [0.5, @2]}", "not before the end"),
    "negative step": ("time", "time: {step: @-0.01, end: 1}", "above 0|positive|> 0"),
    "step beyond the end": ("time", "time: {step: @2, end: 1}", "longer than the simulation"),
    "no step": ("time", "time: @{end: 1}", "missing key 'step'"),
    "no density": ("bodies", "bodies: [@{elasticity: {model: linear, youngs_modulus: 1, poissons_ratio: 0}}]",
                   "density"),
    "bad formula": ("loads", 'loads: [{gravity: [0, 0, "sin(t@"]}]', r"'gravity\[2\]': a '\)' is missing"),
    "formula of an unknown name": ("loads", 'loads: [{gravity: [0, 0, "9.81*@time"]}]', "time"),
    "bad vector": ("loads", "loads: [{gravity: @[0, 0]}]", "3"),
    "key given twice": ("output", "time: {step: 1, @step: 2}", "twice"),
    "tab": ("output", "output:\n@\tdirectory: out", "tab"),
    "unbalanced bracket": ("output", "probes: [{name: tip, point: [0, 0, 0}]", "not valid YAML"),
}
# Mistakes that only the mesh tells, of which a rank has a part.
BAD_AGAINST_THE_MESH = {
    "a mesh of unknown kind": ("mesh", "mesh: {file: @in.yaml}", "in.yaml"),
    "a mesh in parts that is none": ("mesh", "mesh: {file: @bad.h5}", "bad.h5.*not an HDF5 file"),
    "a result as mesh": ("mesh", "mesh: {file: @other.h5}", "other.h5.*not a mesh of Pliant"),
    "misspelt surface": ("constraints", "constraints: [{surface: @lefd, displacement: [0, 0, 0]}]", "did you mean 'left'"),
    "surface as volume": ("bodies", "bodies: [{volume: @left, " + LAW + "}]", "surface: left|surface"),
    "volume as surface": ("constraints", "constraints: [{surface: @body, displacement: [0, 0, 0]}]", "volume"),
    "contact with an unknown part": ("output", "contact: {pairs: [{surface: left, with: @bdoy}]}",
                                     "no volume, surface or rigid body 'bdoy' .did you mean 'body'.*there are: "),
    "contact of an unknown surface": ("output", "contact: {surface: @lefd, obstacles: [{name: a, shape: sphere, radius: 1}]}",
                                      "did you mean 'left'"),
    "contact of no facet": ("output", 'contact: {where: @"x > 10", obstacles: [{name: a, shape: sphere, radius: 1}]}',
                            "no facet"),
    "an open surface as obstacle": ("output", "contact: {obstacles: [{name: a, shape: surface, file: @open.stl}]}",
                                    "not closed: 3 edges"),
    "an obstacle with a corner that is no number": ("output", "contact: {obstacles: [{name: a, shape: surface, "
                                                    "file: @endless.msh}]}", r"triangle \d+ is not finite"),
    "a flat obstacle": ("output", "contact: {obstacles: [{name: a, shape: surface, file: @flat.stl}]}", "flat and encloses no volume"),
    "an obstacle whose sides look different ways": ("output", "contact: {obstacles: [{name: a, shape: surface, file: @turned.stl}]}",
                                                    "at 3 edges two triangles face opposite sides"),
    "an obstacle from no file": ("output", "contact: {obstacles: [{name: a, shape: surface, file: @nowhere.stl}]}",
                                 "nowhere.stl"),
    "a body beyond a barrier": ("output", "contact: {law: barrier, obstacles: [@{name: a, shape: plane, "
                                "normal: [0, 0, 1], point: [0, 0, 0.5]}]}", "touches or overlaps the obstacle 'a' at the start .gap -0.5 m.*leave a gap"),
    "a probe far from the body": ("output", "probes: [@{name: tip, point: [0, 0.5, 100]}]",
                                  r"'tip' lies outside the mesh, 99 m from its nearest point \(0, 0.5, 1\)"),
    "a script that runs a program": ("mesh", "mesh: {file: @commands.geo}",
                                     "line 2, column 1: 'SystemCall' runs a program.*allow_commands: true"),
    "box of nothing": ("constraints", "constraints: [{box: @[[2, 2, 2], [3, 3, 3]], displacement: [0, 0, 0]}]", "no node"),
    "symmetry inside": ("constraints", "constraints: [{surface: @top, symmetry: plane}]", "lies inside the mesh, where a normal has no outside"),
    "pressure inside": ("loads", "loads: [@{surface: top, pressure: 1}]", "lies inside the mesh, .*name a part of the outer surface"),
    "condition on nothing": ("constraints", 'constraints: [{where: @"x > 7", displacement: [0, 0, 0]}]', "no node"),
    "traction on nothing": ("loads", 'loads: [{where: @"x > 7", traction: [0, 0, 1]}]', "no facet"),
    "traction inside": ("loads", 'loads: [{where: @"abs(x - 0.5) < 1e-9", traction: [0, 0, 1]}]', "no facet"),
    "a load without end": ("loads", 'loads: [@{gravity: [0, 0, "1/t"]}]', "not finite at t = 0"),
    "a displacement without end": ("constraints", 'constraints: [@{surface: left, displacement: [0, 0, "log(t)"]}]', "not finite at t = 0"),
    "an initial velocity that is no number": ("output", 'initial: {velocity: ["sqrt(x - 0.5)", 0, 0]}', r"initial velocity is not finite at \("),
    "constraints at odds": ("constraints", "constraints: [{surface: left, displacement: [0, 0, 0]}, "
                            "{surface: right, displacement: [0.1, 0, 0]}, @{surface: top, displacement: [0, 0, 0]}]",
                            "'right' and .*'top'|'top' and .*'right'"),
    "a static body that nothing holds": ("constraints", "constraints: []\ntime: {method: @static}", "constraint"),
    "a column from nowhere": ("output", "output: {history: [{name: a, of: velocity, in: @bdoy, take: max}]}",
                              "no volume, surface or rigid body 'bdoy' .did you mean 'body'"),
    "a column of a probe's name": ("output", "probes: [{name: tip, point: [0, 0, 0]}]\n"
                                   "output: {history: [@{name: tip_x, of: velocity, take: max}]}", "a column 'tip_x' of its own"),
    "unknown field": ("output", "output: {fields: [displacement, @stress]}", "stress"),
    "volumes that do not cover": ("bodies", "bodies: [{volume: @lower, " + LAW + "}]", "upper"),
    "volumes that share tetrahedra": ("bodies", "bodies: [{volume: body, " + LAW + "}, {volume: @whole, " + LAW + "}]",
                                      "48 tetrahedra are in several volumes .*'body', 'whole'"),
    "a curve off the edges": ("loads", "loads: [{curve: @wire, line_force: [0, 0, 1]}]", "'wire' contains no edge of a tetrahedron"),
    "one volume twice": ("bodies", "bodies: [{volume: body, " + LAW + "}, {volume: @body, " + LAW + "}]", "same volume"),
    "an incompressible body that starts deformed": ("bodies", "bodies: [{volume: body, density: 1000, elasticity: {model: neo-hookean, "
                                                    "youngs_modulus: 1e6, poissons_ratio: 0.5}}]\nvolumetric: mixed\n"
                                                    'constraints: [@{surface: left, displacement: ["0.1 + t", 0, 0]}]', "prescribed at t = 0"),
    "initial state inside out": ("output", 'initial: {displacement: ["-2*x", 0, 0]}', "inverts tetrahedra"),
    "a cavity with a loose edge": ("output", "cavities: [@{name: c, surface: right, gas: {}}]", "is open: .* can move"),
    "a cavity around the body": ("output", 'cavities: [@{name: c, where: "x > -1", gas: {}}]', "encloses no cavity"),
    "a cavity and PETSc's integrators": ("time", "time: {method: @{petsc: alpha2}, step: 0.01, end: 1}\n"
                                         'cavities: [{name: c, where: "x > -1", volume: 3, gas: {}}]', "`cavity` couples all"),
    "parts that turn freely and PETSc's integrators": ("constraints", "constraints: [{surface: right, rigid: {}}]\n"
                                                   "time: {method: @{petsc: alpha2}, step: 0.01, end: 1}", "rotate freely"),
    "viscosity as a part of a modulus that fibres have not": (
        "bodies", "bodies: [{density: 1000, elasticity: {model: guccione, C: 1 kPa, bf: 8, bt: 2, bfs: 4, bulk_modulus: 1 MPa, fibre: [1, 0, 0]}, "
        "viscosity: [@{model: stiffness-proportional, time: 2 ms}]}]", "give a viscosity in absolute numbers"),
}
# Number of ranks -> each how many-th case runs on them.
READ_ALIKE = {1: 1, 2: 9}  # each rank has the whole text of the input and of the command line
HELD_IN_PARTS = {1: 1, 2: 6, 4: 24}  # a rank has a part of the mesh, or reads or writes for all
# What can be meant, but seldom is: the run says so and goes on. As above.
DOUBTFUL = {
    "a load on what is held": ("loads", "loads: [@{surface: left, traction: [0, 0, 1]}]", "the load moves nothing"),
    "a load on what moves as given": ("loads", 'loads: [@{where: "x < 1e-9 && z < 0.6", pressure: 1}]', "the load moves nothing"),
    "frames between steps": ("output", "output: {directory: out, every: @1 ms}", "every 0.001 s, but a step is 0.01 s long"),
    "a floor that points away": ("output", "contact: {stiffness: 1, obstacles: [@{name: floor, shape: plane, point: [0, 0, -0.1], normal: [0, 0, -1]}]}",
                                 "starts 1.1 m deep in the obstacle 'floor'.* reverse 'normal'"),
    "an obstacle between contact points": ("output", "contact: {obstacles: [@{name: needle, shape: capsule, axis: [1, 0, 0], point: [0, 0, -1], "
                                           "radius: 0.01, length: 1}]}", "'needle' is 0.02 m wide, but .* it can pass between them"),
    "an obstacle inside the body": ("output", "contact: {obstacles: [@{name: ball, shape: sphere, point: [0.5, 0.5, 0.5], radius: 0.1}]}",
                                    "'ball' starts inside a body"),
    "contact of what is held": ("output", "contact: @{surface: left, obstacles: [{name: floor, shape: plane, normal: [0, 0, 1]}]}",
                                "nothing can touch the obstacles"),
    "bodies at rest": ("loads", "loads: []", "nothing moves the bodies"),
    "motion that starts with a jump": ("constraints", "constraints: [{surface: left, displacement: [0, 0, 0]}, "
                                       "@{where: \"x > 0.9\", displacement: [\"0.1*cos(t)\", 0, 0]}]", "displaces nodes abruptly by 0.1 m"),
    "a mesh in millimetres": ("mesh", "mesh: {file: @cube.msh, scale: 100}", "the mesh is 100 m long.*'scale: 0.001'"),
    "a soft part in millimetres": ("mesh", "mesh: {file: @cube.msh, scale: 40}", "the mesh is 40 m long, and so soft that it would sink by 18 % .*'scale: 0.001'"),
    "an obstacle in millimetres": ("output", "contact: {stiffness: 1, obstacles: [@{name: floor, shape: plane, point: [0, 0, -200], normal: [0, 0, 1]}]}",
                                   r"'floor' at .* is 200 m away from the bodies.* write \[0, 0, -200 mm\]"),
    "a spring to a place in millimetres": ("output", "springs: [{name: s, stiffness: 1, points: [[1, 1, 1], @{body: ground, point: [500, 0, 500]}]}]",
                                           r"the point of spring 's' at .* is 706 m away from the bodies.* write \[500 mm, 0, 500 mm\]"),
    "a joint in millimetres": ("output", "rigid_bodies: [{name: hub, mass: 1, inertia: [1, 1, 1], center: [1, 1, 2]}]\n"
                               "joints: [@{name: pin, type: hinge, between: [hub, ground], point: [500, 0, 500], axis: [1, 0, 0]}]",
                               r"joint 'pin' at .* is 706 m away from the bodies, which are 1.73 m in size"),
    "a mass in millimetres": ("output", "rigid_bodies: [@{name: hub, mass: 1, inertia: [1, 1, 1], center: [500, 0, 500]}]",
                              "the center of mass of 'hub' at .* is 706 m away from the bodies"),
    "rubber that is stretched too far": ("time", "time: {step: 1 us, end: 3 us}\ninitial: {displacement: [\"4.5*x\", 0, 0]}",
                                         "'body' is stretched to 5.5 times its length near X = .*beyond the range of 'neo-hookean'"),
    "constants that soften": ("bodies", "bodies: [{density: 1000, elasticity: @{model: yeoh, c10: 1 MPa, c20: -0.2 MPa, poissons_ratio: 0.4}}]",
                              "'yeoh' is stable only in uniaxial tension up to a stretch of 1.*in equibiaxial tension up to"),
    "fibres that follow a formula": ("bodies", "bodies: [{density: 1, elasticity: @{model: guccione, C: 10 kPa, bf: 20, bt: 4, bfs: 4, "
                                     "bulk_modulus: 1 MPa, fibre: [1, \"x\", 0]}}]", "'guccione' is stable only along the fibres down to a stretch"),
    "parts that overlap": ("mesh", "mesh: {file: @cube.msh}", "overlap at the start, 0.[12][0-9]* m deep"),
    "parts that pass through one another": ("output", 'initial: {velocity: ["-30*(x > 1.4)", 0, 0]}', "at t = 0.02 s two parts of 'body', which share no node, pass through"),
    "two cavities with the same walls": ("output", 'cavities: [{name: c, where: "x < 0.01", volume: 3, pressure: 1}, '
                                         '@{name: d, where: "x < 0.01", volume: 3, pressure: 1}]', "'c' and 'd' have 8 facets of their walls in common"),
    "friction in percent": ("output", "contact: {stiffness: 1, obstacles: [{name: floor, shape: plane, normal: [0, 0, 1], friction: @60}]}",
                            "a coefficient of friction of 60 is far above that of any materials .*; is 0.6 meant"),
    "a key without a value": ("output", "contact:\n  @friction:\n  stiffness: 1\n  obstacles: [{name: floor, shape: plane, normal: [0, 0, 1]}]",
                              "'friction' in contact has no value; it counts as not given"),
    "a section without a value": ("output", "output: {directory: out, @every: }", "'every' in output has no value"),
    "Newton's method that does nothing": ("output", "solver: {newton: {absolute: 1 MN}}", "ended 2 of 2 solves.* these are not solutions"),
}
NOT_DOUBTFUL = {
    "a load on what is held in part": ("loads", "loads: [{surface: top, traction: [0, 0, 1]}, {gravity: [0, 0, -9.81]}]"),
    "a load across what is held": ("constraints", "constraints: [{surface: left, displacement: [0, 0, free]}]\n"
                                   "probes: [{name: a, point: [0, 0, 0]}]"),
    "a wall at a distance": ("output", "contact: {stiffness: 1, obstacles: [{name: wall, shape: plane, point: [-60, 0, -60], normal: [1, 0, 0]}]}"),
    "a default by null": ("output", "contact: {friction: null, viscous_friction: ~, stiffness: 1, obstacles: "
                          "[{name: floor, shape: plane, normal: [0, 0, 1]}]}"),
    "a floor that is touched": ("output", "contact: {stiffness: 1, obstacles: [{name: floor, shape: plane, normal: [0, 0, 1]}]}"),
    "a ball beside the body": ("output", "contact: {stiffness: 1, obstacles: [{name: a, shape: sphere, point: [0.5, 0.5, -0.3], radius: 0.2}]}"),
    "motion from where the body is": ("constraints", "constraints: [{surface: left, displacement: [0, \"0.1*sin(t)\", 0]}]"),
    "a tolerance in newtons": ("output", "solver: {newton: {absolute: 1 nN}}"),
    "parts that stay apart": ("loads", "loads: [{surface: top, traction: [0, 0, 1]}]"),
    "constants that soften a little": ("bodies", "bodies: [{density: 1000, elasticity: {model: yeoh, c10: 1 MPa, c20: -5 kPa, c30: 0.5 kPa, poissons_ratio: 0.4}}]"),
    "frames at steps": ("output", "output: {directory: out, every: 10 ms}"),
}
IN_TWO_VOLUMES = {"volumes that do not cover"}
OF_OTHER_GROUPS = {"volumes that share tetrahedra", "a curve off the edges"}
WITH_A_SECOND_CUBE = {"parts that overlap": (0.8, 0.8, 0.8), "parts that pass through one another": (1.5, 0.1, 0.1),
                      "parts that stay apart": (1.0, 0.1, 0.1)}
TOP_HALFWAY_UP = {"symmetry inside", "pressure inside"}

# Name: arguments, words of the message.
BAD_FILES_AND_OPTIONS = {  # told once ranks do different work
    "no such input": (["run", "nowhere.yaml"], "nowhere.yaml"),
    "an input of nearly this name": (["run", "In.yml"], "there is no such input file .did you mean 'in.yaml'"),
    "a mesh of nearly this name": (["check", "in.yaml", "--set", "mesh.file=Cube.msh"], "does not exist .did you mean 'cube.msh'"),
    "ranks as an option": (["run", "in.yaml", "-n", "3"], "no option '-n'; on several ranks: mpirun -n 3 pliant run"),
    "the beginning of columns": (["sensitivity", "in.yaml", "--of", "left", "--to", "bodies.0.density"], "did you mean 'left_fx', 'left_fy'"),
    "a directory as input": (["run", "folder"], "directory"),
    "an empty input": (["run", "empty.yaml"], "empty"),
    "binary input": (["run", "binary.yaml"], "binary.yaml"),
    "a fit file as input": (["run", "fit.yaml"], "fit.yaml:1:1: this is a fit file, not the input of a run: pliant fit fit.yaml"),
    "an input as fit file": (["fit", "in.yaml"], "in.yaml:1:1: this is the input of a run, not a fit file"),
    "a script without its kernel": (["mesh", "convert", "kernel.geo", "a.h5"], r'begin the script with SetFactory\("OpenCASCADE"\)'),
    "a mesh as input": (["run", "cube.msh"], r"name it in one .YAML.: 'mesh: \{file: cube.msh\}'"),
    "HDF5 as input": (["run", "bad.h5"], "pliant resume"),
    "PETSc options in no file": (["methods", "--", "-options_file", "nowhere.txt"], "PETSc options: .*nowhere.txt"),
    "PETSc options without a dash": (["run", "in.yaml", "--", "ksp_type", "cg"], "'ksp_type' belongs to no option"),
    "PETSc options of two values": (["run", "in.yaml", "--", "-ksp_type", "cg", "cr"], "'cr' belongs to no option"),
    "PETSc options that do not fit": (["run", "in.yaml", "--", "-pc_type", "nonsense"], "PETSc options: .*nonsense"),
    "a mesh to convert that is missing": (["mesh", "convert", "nowhere.msh", "a.h5"], "nowhere.msh.*does not exist"),
    "a mesh to convert into another format": (["mesh", "convert", "cube.msh", "cube.vtk"], "must be named .h5"),
    "a mesh that is converted already": (["mesh", "convert", "bad.h5", "a.h5"], "own format already"),
    "a script to convert that runs a program": (["mesh", "convert", "commands.geo", "a.h5"], "'SystemCall' runs.*--allow-commands"),
    "a size that is no length": (["mesh", "convert", "bad.geo", "a.h5", "--size", "2 kg"], "--size 2 kg"),
    "a scale that turns inside out": (["mesh", "convert", "cube.msh", "a.h5", "--scale", "-1"], "scale must be a positive"),
    "check of a bad input": (["check", "in.yaml", "--set", "mesh.file=nowhere.msh"], "nowhere.msh"),
}
BAD_COMMANDS = {
    "no command": ([], "subcommand|command"),
    "unknown command": (["runn", "in.yaml"], "'runn' .*did you mean 'run'"),
    "a column without its option": (["plot", "out", "tip_z"], "takes no argument 'tip_z'; columns are given by --of tip_z"),
    "an option of few": (["plot", "out", "--columns", "tip_z"], "no option '--columns'; its options are: .*--of"),
    "a command of few": (["mesh", "cube.msh"], "no command 'cube.msh'; its commands are: convert"),
    "a key of three sections": (["run", "in.yaml", "--set", "end=1"], r"unknown key 'end' .it belongs in rods.* time"),
    "an entry by another name": (["run", "in.yaml", "--set", "bodies.cube.density=1"], "its only entry has the number 0"),
    "an input without a command": (["in.yaml"], "to run an input: pliant run in.yaml"),
    "no input": (["run"], "INPUT is required; see pliant run --help"),
    "a setting without --set": (["run", "in.yaml", "time.step=5ms"], "by --set time.step=5ms"),
    "nothing to do with a mesh": (["mesh"], "subcommand"),
    "nowhere to convert to": (["mesh", "convert", "cube.msh"], "OUTPUT"),
    "unknown option": (["run", "in.yaml", "--outputs", "x"], "--outputs"),
    "option without value": (["run", "in.yaml", "--output"], "--output"),
    "set without value": (["run", "in.yaml", "--set", "time.step"], "KEY.PATH=VALUE"),
    "set an unknown key": (["run", "in.yaml", "--set", "time.stop=1"], "did you mean 'step'|stop"),
    "set a bad value": (["run", "in.yaml", "--set", "time.step=1 kg"], "1 kg"),
    "set an entry in brackets": (["run", "in.yaml", "--set", "bodies[0].density=1"], "numbers after dots, such as bodies.0.density"),
    "set something behind a list": (["run", "in.yaml", "--set", "output.fields=[velocity] m"], "after the closing bracket"),
    "output into nothing": (["run", "in.yaml", "--output", ""], "--output: the name is empty"),
    "set beyond the list": (["run", "in.yaml", "--set", "bodies.3.density=1"], "bodies"),
}


def stl(*corners):
    """The faces of a tetrahedron."""
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    return "solid a\n" + "".join("facet normal 0 0 0\nouter loop\n" + "".join(f"vertex {corners[c]}\n" for c in face) +
                                 "endloop\nendfacet\n" for face in faces) + "endsolid a\n"


BAD_STL = {
    "open": stl("0 0 0", "1 0 0", "0 1 0", "0 0 1").rsplit("facet normal", 1)[0] + "endsolid a\n",
    "flat": stl("0 0 0", "1 0 0", "0 1 0", "1 1 0"),
    "turned": stl("0 0 0", "1 0 0", "0 1 0", "0 0 1").replace("vertex 0 1 0\nvertex 1 0 0\n", "vertex 1 0 0\nvertex 0 1 0\n", 1),
}


class Errors(MistakesTest):
    def case(self, name):
        """A directory with the good input and meshes, and what users name by mistake."""
        directory = self.directory / re.sub(r"\W+", "_", name)
        directory.mkdir()
        (directory / "in.yaml").write_text("\n".join(LINES.values()) + "\n")
        (directory / "folder").mkdir()
        (directory / "empty.yaml").write_text("")
        (directory / "empty.msh").write_text("")
        (directory / "bad.h5").write_bytes(bytes(range(256)))
        with h5py.File(directory / "other.h5", "w") as other:
            other.attrs["format"] = "pliant-result"
        (directory / "binary.yaml").write_bytes(bytes(range(256)))
        (directory / "bad.geo").write_text("Point(1) = {0, 0, 0};\nLine(1) = {1, 2;\n")
        (directory / "fit.yaml").write_text("material: {model: yeoh}\ntests: [{kind: uniaxial, data: a.csv}]\n")
        (directory / "kernel.geo").write_text("Box(1) = {0, 0, 0, 1, 1, 1};\n")
        (directory / "commands.geo").write_text("x = 1;\nSystemCall \"touch made\";\n")
        (directory / "flat.geo").write_text('SetFactory("OpenCASCADE");\nRectangle(1) = {0, 0, 0, 1, 1};\n')
        for kind, text in BAD_STL.items():
            (directory / f"{kind}.stl").write_text(text)
        if name in IN_TWO_VOLUMES:
            points, triangles, cells = box((2, 2, 2))
            above = (points[cells].mean(axis=1)[:, 2] > 0.5).astype(int)
            write_mesh(directory / "cube.msh", points, triangles, cells, (["lower", "upper"], above))
        elif name in WITH_A_SECOND_CUBE:
            points, triangles, cells = box((2, 2, 2))
            cells = np.vstack([cells, cells + len(points)])
            write_mesh(directory / "cube.msh", np.vstack([points, points + WITH_A_SECOND_CUBE[name]]), triangles, cells)
        elif name in TOP_HALFWAY_UP:
            points, triangles, cells = box((2, 2, 2))
            faces = np.unique(np.sort(cells[:, list(itertools.combinations(range(4), 3))].reshape(-1, 3), axis=1), axis=0)
            triangles[-1] = faces[(points[faces][:, :, 2] == 0.5).all(axis=1)]
            write_mesh(directory / "cube.msh", points, triangles, cells)
        elif name in OF_OTHER_GROUPS:
            brick = Brick()
            brick.names += [(3, 8, "whole"), (1, 9, "wire")]
            brick.blocks.insert(0, (1, 9, LINE, 9, [[1, 27]]))  # a diagonal of the cube
            (directory / "cube.msh").write_bytes(brick.msh4().replace(b" 1 7 0\n", b" 2 7 8 0\n"))
        else:
            write_box(directory / "cube.msh", (2, 2, 2))
        (directory / "endless.msh").write_text((directory / "cube.msh").read_text().replace(" 1.0 1.0 1.0\n", " 1.0 1.0 nan\n"))
        return directory

    def test_the_good_input_is_good(self):
        self.assertEqual(finish(start(["run", "in.yaml"], self.case("good")), 60).returncode, 0)

    def cases_of(self, bad_lines):
        cases = {}
        for name, (key, replacement, words) in bad_lines.items():
            directory = self.case(name)
            lines = {k: line for k, line in LINES.items() if f"\n{k}:" not in replacement} | {key: replacement}
            text = "\n".join(lines.values()) + "\n"
            place = "in.yaml:"
            if "@" in text:
                before = text[: text.index("@")]
                place = f"in.yaml:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}:"
            (directory / "in.yaml").write_text(text.replace("@", ""))
            cases[name] = (directory, ["run", "in.yaml"], 2, place, words)
        return cases

    def test_what_is_doubtful(self):
        """One warning, with its place, and the run goes on."""
        cases = {name: (directory, [*arguments, "--quiet"], 0, place, "^warning: .*" + words)
                 for name, (directory, arguments, _, place, words) in self.cases_of(DOUBTFUL).items()}
        self.judge_all(cases, {1: 1, 2: 8})
        meant = {name: (*row, "^$") for name, row in NOT_DOUBTFUL.items()}
        cases = {name: (directory, [*arguments, "--quiet"], 0, None, words)
                 for name, (directory, arguments, _, _, words) in self.cases_of(meant).items()}
        self.judge_all(cases, {1: 1})

    def test_places_of_rigid_bodies_in_millimetres(self):
        directory = self.case("rigid bodies")
        rest = "}]\nloads: [{gravity: [0, 0, -9.81]}]\ntime: {step: 0.01, end: 0.02}\n"
        inertia = "mass: 1, inertia: [1, 1, 1]"
        (directory / "shape.yaml").write_text(f"rigid_bodies: [{{name: hub, {inertia}, center: [5, 0, 5], surface: {{file: cube.msh}}" + rest)
        (directory / "points.yaml").write_text(f"rigid_bodies: [{{name: a, {inertia}, center: [5, 0, 0]}}, {{name: b, {inertia}, center: [90, 0, 0]" + rest)
        self.judge_all({
            "centre": (directory, ["run", "shape.yaml", "--quiet"], 0, "shape.yaml:1:16:",
                       r"^warning: .*'hub' at .* is 5.66 m outside its surface, which is 1.73 m in size; places are in metres: .* write \[5 mm, 0, 5 mm\]"),
            "no mesh": (directory, ["run", "points.yaml", "--quiet"], 0, "points.yaml", "^warning: .*extend over .* m; places are in metres: write '5 mm'"),
        }, {1: 1, 2: 1})

    def test_mistakes_in_the_input(self):
        self.judge_all(self.cases_of(BAD_LINES), READ_ALIKE)

    @long_test  # runs the program six hundred times
    def test_mistakes_that_are_tried_in_process(self):
        kept = self.directory / "kept"
        kept.mkdir()
        subprocess.run([PROGRAM.with_name("test_input"), "--gtest_filter=*IsToldOnceAtItsPlace*"], check=True, stdout=subprocess.DEVNULL,
                       env=ENVIRONMENT | {"PLIANT_KEEP_MISTAKES": str(kept)})
        cases = {}
        for told in kept.glob("*.told"):
            place, message = told.read_text().split("\n", 1)
            cases[f"{told.stem}: {message}"] = (kept, ["run", told.stem], 2, place, re.escape(message))
        self.assertGreater(len(cases), 200)
        self.judge_all(cases, {1: 1, 2: 1})

    def test_mistakes_against_the_mesh(self):
        self.judge_all(self.cases_of(BAD_AGAINST_THE_MESH), HELD_IN_PARTS)

    def test_contact_of_what_belongs_to_no_body(self):
        directory = self.case("no body")
        points, triangles, cells = box((4, 1, 1))
        write_mesh(directory / "two.msh", points, triangles, cells, (["slab", "block"], (points[cells, 0].mean(axis=1) > 0.5).astype(int)))
        (directory / "in.yaml").write_text("mesh: {file: two.msh}\nbodies: [{volume: slab, " + LAW + "}]\n"
                                           "contact: {pairs: [{surface: right, with: left}]}\ntime: {method: bdf2, step: 1 ms, end: 1 ms}\n")
        self.judge_all({"": (directory, ["check", "in.yaml"], 2, "in.yaml:2", "12 tetrahedra belong to no body; add a body for volume block")}, HELD_IN_PARTS)

    def test_bad_command_lines(self):
        for commands, every in ((BAD_COMMANDS, READ_ALIKE), (BAD_FILES_AND_OPTIONS, HELD_IN_PARTS)):
            cases = {name: (self.case("command " + name), arguments, 2, None, words)
                     for name, (arguments, words) in commands.items()}
            self.judge_all(cases, every)

    def test_inputs_where_results_are_expected(self):
        directory = self.case("input as a result")
        words = "in.yaml' is .*an input.*: give the directory of its results, such as out/in"
        self.judge_all({command: (directory, [command, "in.yaml"], 4, None, words) for command in ("info", "report", "resume")}, {1: 1})

    def test_results_that_are_elsewhere(self):
        """One or two directories below what is named, or one above."""
        directory = self.case("results elsewhere")
        for name in ("out/a", "out/b"):
            (directory / name).mkdir(parents=True)
            for file in ("result.h5", "history.csv"):
                (directory / name / file).write_text("")
        (directory / "out/a/pictures").mkdir()
        for command in ("report", "info", "render", "plot"):
            for place, words in ((".", "there are results in out/a, out/b"), ("out", "there are results in out/a, out/b"),
                                 ("out/a/pictures", "there is one in out/a"), ("out/a/none", "there is one in out/a|there is no file")):
                self.judge_all({f"{command} {place}": (directory, [command, place], 4, None, words)}, {1: 1})
        self.judge_all({"compare": (directory, ["compare", "out", "out/b"], 2, None, "there are results in out/a, out/b")}, {1: 1})

    def test_output_that_cannot_be_written(self):
        cases = {}
        for name, way in {"a file in the way": "in.yaml", "a file as parent": "in.yaml/out"}.items():
            cases[name] = (self.case("output " + name), ["run", "in.yaml", "--output", way], 4, None, "in.yaml")
        for file in ("history.csv", "result.h5", "result.xdmf", "run.yaml"):
            directory = self.case("output " + file)
            (directory / "out" / file / "taken").mkdir(parents=True)
            cases["a directory in the place of " + file] = (directory, ["run", "in.yaml"], 4, None, file)
        directory = self.case("output summary.json")
        (directory / "out/summary.json/taken").mkdir(parents=True)  # the run itself is safe
        cases["a directory in the place of summary.json"] = (directory, ["run", "in.yaml", "--quiet"], 0, None, "^warning: .*summary.json")
        cases["no folder for a mesh"] = (self.case("no folder"), ["mesh", "convert", "cube.msh", "no/cube.h5"], 4, None, "no/cube.h5")
        if os.geteuid() != 0:  # nothing is read-only to root
            directory = self.case("output read-only")
            (directory / "out").mkdir(mode=0o500)
            cases["a read-only directory"] = (directory, ["run", "in.yaml"], 4, None, "out")
            directory = self.case("input unreadable")
            (directory / "in.yaml").chmod(0)
            cases["an unreadable input"] = (directory, ["run", "in.yaml"], 2, None, "permissions")
        elif os.path.isdir("/proc"):
            cases["a file system without files"] = (self.case("output proc"), ["run", "in.yaml", "--output", "/proc/pliant"], 4,
                                                    None, "/proc/pliant")
        self.judge_all(cases, HELD_IN_PARTS)

    def test_units_without_their_database(self):
        nowhere = UNSIGNALLED | {"UDUNITS2_XML_PATH": "/nowhere"}
        done = finish(start(["run", "in.yaml", "--set", "time.step=5 ms"], self.case("units"), 2, nowhere), 60)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertEqual(done.stderr.count("install udunits2's data"), 1, done.stderr)
        self.assertNotIn("failed on rank", done.stderr)

    @unittest.skipIf("ASAN_OPTIONS" in os.environ, "AddressSanitizer takes addresses without end")
    def test_too_little_memory(self):
        """What nobody could foresee has a code of its own: it is neither the solver's nor a file's."""
        limit = 800 * 2**20
        done = subprocess.run([PROGRAM, "run", "in.yaml", "--set", "mesh.refine=6"], cwd=self.case("memory"), env=ENVIRONMENT, text=True,
                              capture_output=True, timeout=60, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        self.assertEqual(done.returncode, 70, done.stderr)
        self.assertIn("pliant failed on rank 0", done.stderr)

    def test_all_mistakes_at_once(self):
        directory = self.case("several")
        lines = LINES | {"time": "time: {step: 1 kg, end: 0.02, ende: 1}", "output": "outputs: {}"}
        (directory / "in.yaml").write_text("\n".join(lines.values()) + "\n")
        done = finish(start(["run", "in.yaml"], directory, 2), 60)
        self.assertEqual(done.returncode, 2)
        for place in ("in.yaml:5:14:", "in.yaml:5:31:", "in.yaml:6:1:"):
            self.assertEqual(done.stderr.count(place), 1, done.stderr)

    def test_formulas_that_end_being_numbers(self):
        """Such a run fails at once, at the formula; what was reached is kept."""
        cases = {}
        # A jump is an event: what follows acts from there on.
        for name, (key, line, time) in {
                "load": ("loads", 'loads: [@{gravity: [0, 0, "sqrt(0.012 - t)"]}]', 0.02),
                "pressure": ("loads", 'loads: [@{surface: top, pressure: "1/(t < 0.015)"}]', 0.02),
                "displacement": ("constraints", 'constraints: [@{surface: left, displacement: [0, 0, "0*sqrt(0.012 - t)"]}]', 0.02),
        }.items():
            directory = self.case("late " + name)
            text = "\n".join((LINES | {key: line}).values()) + "\n"
            before = text[: text.index("@")]
            (directory / "in.yaml").write_text(text.replace("@", ""))
            place = f"in.yaml:{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}:"
            cases[name] = (directory, ["run", "in.yaml", "--quiet"], 3, place, f"is not finite at t = {time}.*try: another formula, or an earlier time.end")
        self.judge_all(cases, {1: 1, 2: 1})

    def test_mistakes_against_the_mesh_at_once(self):
        directory = self.case("several groups")
        lines = LINES | {"constraints": "constraints: [{surface: lefd, displacement: [0, 0, 0]}, "
                                        "{surface: topp, displacement: [0, 0, 0]}]"}
        (directory / "in.yaml").write_text("\n".join(lines.values()) + "\n")
        done = finish(start(["run", "in.yaml"], directory, 2), 60)
        self.assertEqual(done.returncode, 2)
        for hint in ("'left'", "'top'"):
            self.assertIn(f"did you mean {hint}", done.stderr)


if __name__ == "__main__":
    unittest.main()
