"""Pictures one after another as a movie."""
import shutil
import subprocess

from PIL import Image

from pliant import PliantError


def write_movie(pictures, file, frames_per_second):
    if file.endswith(".gif"):
        pictures = [picture.quantize(128, dither=Image.NONE) for picture in pictures]
        pictures[0].save(file, save_all=True, append_images=pictures[1:], duration=round(1000 / frames_per_second), loop=0)
        return
    program = shutil.which("ffmpeg")
    if program is None:
        raise PliantError("a movie needs the package 'ffmpeg' (an animated GIF does not: --movie gif)")
    encoder = None
    for picture in pictures:
        if encoder is None:
            command = [program, "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s",
                       f"{picture.width}x{picture.height}", "-r", f"{frames_per_second:g}", "-i", "-", "-vf",
                       "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p", "-movflags",
                       "+faststart", file]
            encoder = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)
        try:
            encoder.stdin.write(picture.tobytes())
        except BrokenPipeError:
            break
    _, errors = encoder.communicate()
    if encoder.returncode != 0:
        raise PliantError(f"ffmpeg could not write {file}: {errors.decode(errors='replace').strip().splitlines()[-1]}")
