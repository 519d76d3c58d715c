"""A screen to draw on, where there is none."""
import atexit
import ctypes
import os
import shutil
import subprocess

from pliant import PliantError


def start_screen():
    """A virtual X server of our own; one that is there already serves only if Xvfb is missing."""
    program = shutil.which("Xvfb")
    if program is None:
        if os.environ.get("DISPLAY"):
            return
        raise PliantError("pictures need a screen or a virtual one: install the package 'xvfb'")
    read, write = os.pipe()
    display = f":{1000 + os.getpid()}"  # servers that look for a free number take each other's
    server = subprocess.Popen(
        [program, display, "-displayfd", str(write), "-screen", "0", "640x480x24", "-nolisten", "tcp", "+extension", "GLX"],
        pass_fds=[write], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        start_new_session=True, preexec_fn=_die_with_parent)
    os.close(write)
    atexit.register(_end, server)
    with os.fdopen(read) as pipe:
        number = pipe.readline().strip()
    if not number:
        raise PliantError("the virtual screen (Xvfb) did not start")
    os.environ["DISPLAY"] = f":{number}"
    os.environ.pop("XAUTHORITY", None)
    os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"


def _die_with_parent():
    death_signal, terminate = 1, 15  # PR_SET_PDEATHSIG, SIGTERM
    ctypes.CDLL(None).prctl(death_signal, terminate)


def _end(server):
    server.terminate()
    server.wait()
