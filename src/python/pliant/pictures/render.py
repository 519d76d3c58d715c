"""Turns a result of Pliant into a picture, a series of pictures, a movie, or a model that moves.

Needs no screen: VTK draws into a virtual one, which this program starts and ends.
"""
import argparse
import os
import re

import numpy as np

from pliant import PliantError, Result

from .camera import VIEWS
from .colours import MAPS
from .cut import mirror, plane
from ..command_line import Parser, exit_code
from ..start import missing, needs


def chosen_frames(result, options):
    series = options.frames or options.movie
    if options.frame is None:
        return result.frames if series else result.frames[-1:]
    if options.frame == "last":
        return result.frames[-1:]
    count = len(result.frames)
    if not -count <= options.frame < count:
        raise PliantError(f"--frame {options.frame}: the result has the frames 0 to {count - 1}")
    return [result.frames[options.frame]]


def is_model(options):
    """Is a .glb wanted?"""
    return options.movie == "glb" or (options.output or "").lower().endswith(".glb")


def write_model(result, options):
    """All frames as an animation, at their times or, with --fps, evenly; without --movie and with --frame that frame alone. --frame is
    also the one whose colours are shown, by default the last."""
    from .model import Model

    for name in ("view", "size", "mesh_edges", "outline", "frames", "cut", "mirror", "no_axes"):
        if getattr(options, name) != parser_of("").get_default(name):
            raise PliantError(f"--{name.replace('_', '-')} has no effect on a .glb, which is a model instead of a picture: leave it out")
    file = options.output or os.path.join(result.directory, "movie.glb")
    if not file.lower().endswith(".glb") or options.movie not in (None, "glb"):
        raise PliantError(f"{file}: the name of a model ends in .glb, those of movies in .mp4 or .gif")
    shown = chosen_frames(result, argparse.Namespace(frames=False, movie=None, frame=options.frame))[0]
    frames = [shown] if options.frame is not None and options.movie is None else result.frames
    times = np.array([frame.time for frame in frames])
    if options.fps is not None:
        times = np.arange(len(frames)) / options.fps
    Model(result, frames, shown, options).write(file, times - times[0])
    print(file)


def run(options):
    result = Result(options.result)
    if options.field is None:
        options.field = "displacement" if "displacement" in chosen_frames(result, options)[0].field_names else "none"
    if is_model(options):
        write_model(result, options)
        return
    frames = chosen_frames(result, options)
    from .movie import write_movie
    from .renderer import Renderer  # which needs VTK
    from .screen import start_screen

    lacking = missing(needs("render", [options.movie or ""]))
    if lacking:
        raise PliantError(lacking)
    renderer = Renderer(result, frames, options)
    start_screen()
    if options.movie:
        file = options.output or os.path.join(result.directory, f"movie.{options.movie}")
        write_movie((renderer.picture(frame) for frame in frames), file, options.fps or 25)
        print(file)
    elif options.frames:
        folder = options.output or os.path.join(result.directory, "frames")
        os.makedirs(folder, exist_ok=True)
        for i, frame in enumerate(frames):
            renderer.picture(frame).save(os.path.join(folder, f"frame_{i:04}.png"))
        print(f"{folder}/frame_0000.png to frame_{len(frames) - 1:04}.png")
    else:
        file = options.output or os.path.join(result.directory, "picture.png")
        renderer.picture(frames[0]).save(file)
        print(file)


def _view(text):
    if text in VIEWS:
        return VIEWS[text]
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 3 or not np.linalg.norm(numbers) > 0:
        raise argparse.ArgumentTypeError(f"'{text}' is none of {', '.join(VIEWS)}, nor a direction such as 1,-1,0.5")
    return numbers


def _size(text):
    width, height = (int(part) for part in text.lower().split("x"))
    if not (160 <= width <= 8192 and 120 <= height <= 8192):
        raise argparse.ArgumentTypeError(f"{text}: sizes go from 160x120 to 8192x8192")
    return width, height


def _frame(text):
    return "last" if text == "last" else int(text)


def _range(text):
    low, high = (float(part) for part in text.split(","))
    if not low < high:
        raise ValueError
    return low, high


def _positive(text):
    number = float(text)
    if not 0 < number < np.inf:
        raise ValueError
    return number


def _finite(text):
    number = float(text)
    if not np.isfinite(number):
        raise ValueError
    return number


def _plane(text):
    return plane(text)


def _mirror(text):
    return mirror(text)


# argparse puts these names into its message: "invalid WIDTHxHEIGHT value: '3'".
_view.__name__, _size.__name__, _frame.__name__ = "view", "WIDTHxHEIGHT", "frame"
_plane.__name__, _mirror.__name__ = "plane (x, y=0.01, y=10mm or 1,0,1=0.02)", "plane (x, y=0.01 or y=10mm)"
_range.__name__, _positive.__name__, _finite.__name__ = "LOW,HIGH", "positive", "number"


def _with_negative_values(arguments):
    """`--view -1,0,0` as `--view=-1,0,0`: argparse takes what begins with a minus sign for another option."""
    joined = []
    for word in arguments:
        if joined and joined[-1] in ("--view", "--range", "--cut") and re.match(r"-[\d.]", word):
            joined[-1] += "=" + word
        else:
            joined.append(word)
    return joined


def parser_of(program):
    parser = Parser(prog=program, description=__doc__.split("\n")[0])
    parser.add_argument("result", help="the output directory of a run, its result.xdmf or its result.h5")
    parser.add_argument("-o", "--output", help="file to write (with --frames: directory), a picture, or all frames as a 3D model (.glb); "
                        "default: in the output directory")
    parser.add_argument("--field", help="what colours the body: displacement (default), velocity, von_mises_stress, "
                        "velocity_z, cauchy_stress_xx, body, rank, ..., tension (colours tendons and springs), or none")
    parser.add_argument("--range", type=_range, metavar="LOW,HIGH", help="of the colours, in SI units; default: that of all frames")
    parser.add_argument("--colour-map", choices=("auto", *MAPS), default="auto", help="viridis; cividis, the same for every colour vision; inferno; "
                        "greys; diverging: blue to red about 0; default: auto, diverging for values of both signs, else viridis")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--frames", action="store_true", help="write every frame as a PNG")
    what.add_argument("--movie", choices=("mp4", "gif", "glb"), help="write a movie of all frames, or a 3D model that moves (.glb)")
    parser.add_argument("--fps", type=_positive, help="frames per second of the movie (25); of a .glb, which otherwise plays in real time")
    parser.add_argument("--frame", type=_frame, metavar="N|last", help="which frame to draw, from 0; -1 or last is the last (default: last)")
    parser.add_argument("--view", type=_view, default=VIEWS["iso"], metavar="X,Y,Z|NAME",
                        help=f"where the viewer stands, seen from the body: a direction X,Y,Z or one of {', '.join(VIEWS)} (iso)")
    parser.add_argument("--size", type=_size, default=(1280, 800), metavar="WxH", help="in pixels (1280x800)")
    parser.add_argument("--scale", type=_finite, default=1.0, help="displacements are multiplied by it (1); obstacles, tendons, "
                        "springs and joints are drawn at 1 only")
    parser.add_argument("--mesh-edges", action="store_true", help="draw the edges of the elements")
    parser.add_argument("--outline", action="store_true", help="draw the edges of the undeformed shape")
    parser.add_argument("--cut", type=_plane, metavar="PLANE", help="take away what the undeformed bodies have on the viewer's side of a plane: y "
                        "(through their middle), y=0.01, or NORMAL=OFFSET such as 1,0,1=0.02 [m]")
    parser.add_argument("--mirror", type=_mirror, action="append", default=[], metavar="PLANE",
                        help="draw the bodies of half a model and their image at x=0 (x), or at a plane such as y=0.01; may be repeated")
    parser.add_argument("--no-axes", action="store_true", help="leave out the axes and the scale bar")
    parser.add_argument("--hide", action="append", default=[], metavar="NAME", help="leave out a body, an obstacle, a tendon, a spring or a joint; may be repeated")
    parser.add_argument("--transparent", action="append", default=[], metavar="NAME",
                        help="draw a body or an obstacle transparent; may be repeated")
    parser.add_argument("--title", help="instead of the run's title")
    return parser


def main(arguments, program):
    options = parser_of(program).parse_args(_with_negative_values(arguments))
    return exit_code(program, lambda: run(options), PliantError, options.output, ".png, .jpg, .tif, .glb")
