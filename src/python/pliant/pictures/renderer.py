"""Frames of a result as pictures, all with the same camera and colour scale."""
import itertools

import numpy as np

from .analysis import counted
from .camera import fitted_camera
from .page import Page, instants_as_text
from .scene import Scene, Sides
from .shown import TRANSPARENT, Shown


class Renderer:
    """Draws `chosen` frames of a result."""

    def __init__(self, result, chosen, options):
        self._options = options
        self._shown = shown = Shown(result, chosen, options)
        self._scenes = {}
        title = options.title if options.title is not None else result.title
        self._page = Page(options.size, title, shown.quantity, shown.colours)
        self._instants = dict(zip((frame.name for frame in result.frames), instants_as_text(result.frames, counted(result.directory))))
        clouds = [*shown.clouds(), *shown.near_obstacles(), *shown.mechanism_clouds()]
        self._camera = fitted_camera(options.view, clouds, self._page.scene_size)

    def _scene(self, frame):
        if frame.mesh_group not in self._scenes:
            shown = self._shown
            shells = shown.shells(frame)
            scene = Scene(shells, self._page.scene_size, self._options)
            obstacles = shown.obstacles(frame)
            if obstacles is not None:
                self._add_obstacles(scene, obstacles)
            if shown.mechanisms(frame) is not None:
                everything = np.concatenate([shown.bodies, *shown.mechanism_clouds()])
                scene.add_mechanisms(np.linalg.norm(np.ptp(everything, axis=0)))
            if self._options.outline:
                for shell in shells:
                    scene.add_outline(shown.reference(shell, frame), shell.triangles)
            scene.aim(self._camera)
            self._scenes[frame.mesh_group] = scene
        return self._scenes[frame.mesh_group]

    def _add_obstacles(self, scene, obstacles):
        """Vessels without the walls in front, which bodies are behind."""
        clear = np.isin(np.array(obstacles.names)[obstacles.obstacle], self._options.transparent)
        is_vessel = np.isin(obstacles.obstacle, obstacles.vessels())
        for of_vessels, opacity in itertools.product((False, True), (1.0, TRANSPARENT)):
            chosen = (is_vessel == of_vessels) & (clear == (opacity < 1))
            if chosen.any():
                scene.add_obstacles(obstacles.triangles[chosen], opacity, Sides.FACING if of_vessels else Sides.BOTH)

    def picture(self, frame):
        shown = self._shown
        pixels = self._scene(frame).draw(shown.positions(frame), shown.colours_of(frame), shown.is_by_face, shown.obstacle_points(frame),
                                         shown.mechanisms(frame))
        return self._page.compose(pixels, self._instants[frame.name], None if self._options.no_axes else self._camera)
