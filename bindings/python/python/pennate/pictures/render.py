"""Lights surfaces and takes their picture, with lines along the edges of what is seen."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pyvista
import vtk
from matplotlib.colors import to_rgb
from scipy.ndimage import uniform_filter
from vtk.util.numpy_support import vtk_to_numpy

from .results import Array
from .surfaces import Surface
from .view import Frame, View

# Pixels are this many times as fine, in each direction, while a picture is drawn.
FINER = 3
# VTK draws pictures of at most so many pixels a side in one piece.
LARGEST = 8192

Image = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Taken:
    """A picture of a network: red, green, blue and opacity, 0 to 1, and how near to the reader what is seen lies."""

    image: Image
    # Along the line of sight, in units of the network; minus infinity where nothing is seen. First row uppermost.
    heights: Array
    frame: Frame
    view: View

    def sees(self, place: Array, radius: float) -> bool:
        """Whether a ball is seen, and not hidden behind something else."""
        part = (self.view.flat(place) - self.frame.low) / self.frame.size
        rows, columns = self.heights.shape
        row = int(np.clip((1.0 - part[1]) * rows, 0, rows - 1))
        column = int(np.clip(part[0] * columns, 0, columns - 1))
        # What covers it is nearer by more than its own surface is.
        return bool(self.heights[row, column] <= place @ self.view.towards + 1.5 * radius)


def render(
    surface: Surface, view: View, frame: Frame, pixels: float, edge: tuple[str, float], edge_jump: float
) -> Taken:
    """A picture of a frame at so many pixels a unit of the network.

    `edge` is the colour and the opacity of lines where the depth jumps by more than `edge_jump`.
    """
    size = np.maximum(np.round(frame.size * pixels), 1).astype(int)
    finer = max(1, min(FINER, LARGEST // int(size.max())))
    colour, heights = take(surface, view, frame, size * finer)
    image = np.dstack([colour, np.isfinite(heights).astype(np.float64)])
    image = with_edges(image, heights, edge, edge_jump, finer)
    return Taken(shrunk(image, finer), heights[finer // 2 :: finer, finer // 2 :: finer], frame, view)


def take(surface: Surface, view: View, frame: Frame, size: npt.NDArray[np.int_]) -> tuple[Image, Array]:
    """Colours, and how near to the reader what is seen lies, minus infinity where nothing is."""
    mesh = surface.mesh(view.towards)
    plotter = pyvista.Plotter(off_screen=True, window_size=[int(size[0]), int(size[1])], lighting="none", border=False)
    plotter.set_background("black")  # type: ignore[arg-type]
    mesh.GetPointData().SetActiveNormals("Normals")
    actor = plotter.add_mesh(
        mesh,
        scalars="colour",
        rgb=True,
        ambient=0.36,
        diffuse=0.66,
        specular=0.14,
        specular_power=22,
        show_scalar_bar=False,
        copy_mesh=False,
    )
    actor.prop.interpolation = "Phong"
    for place, strength in (((-0.3, 1.0, 1.5), 0.88), ((0.6, -0.6, 0.8), 0.26)):
        plotter.add_light(pyvista.Light(position=place, light_type="camera light", intensity=strength))
    bounds = np.array(mesh.bounds).reshape(3, 2)
    reach = float(np.linalg.norm(bounds[:, 1] - bounds[:, 0])) or 1.0
    # The centre of the frame, at the depth of the centre of the network.
    middle = 0.5 * (frame.low + frame.high)
    centre = middle[0] * view.right + middle[1] * view.up + (bounds.mean(axis=1) @ view.towards) * view.towards
    camera = plotter.camera
    camera.focal_point, camera.position, camera.up = centre, centre + reach * view.towards, view.up
    camera.parallel_projection = True
    camera.parallel_scale = 0.5 * float(frame.size[1])
    camera.clipping_range = (0.0, 2.0 * reach)
    window = plotter.render_window
    assert window is not None
    window.SetMultiSamples(0)
    plotter.show(auto_close=False)
    camera.clipping_range = (0.0, 2.0 * reach)
    window.Render()
    colour = grab(plotter, size, depth=False) / 255.0
    depth = grab(plotter, size, depth=True)
    plotter.close()
    nearest = float(np.asarray(centre) @ view.towards) + reach
    return colour, np.where(depth < 1.0, nearest - depth * 2.0 * reach, -np.inf)


def grab(plotter: pyvista.Plotter, size: npt.NDArray[np.int_], depth: bool) -> npt.NDArray[np.float64]:
    """The colours or the depths of a window, first row uppermost."""
    window = vtk.vtkWindowToImageFilter()
    window.SetInput(plotter.render_window)
    window.ReadFrontBufferOff()
    window.ShouldRerenderOff()
    if depth:
        window.SetInputBufferTypeToZBuffer()
    else:
        window.SetInputBufferTypeToRGB()
    window.Update()
    flat = vtk_to_numpy(window.GetOutput().GetPointData().GetScalars())
    shape = (size[1], size[0]) if depth else (size[1], size[0], 3)
    return np.asarray(flat.reshape(shape)[::-1], dtype=np.float64)


def with_edges(image: Image, heights: Array, edge: tuple[str, float], jump: float, finer: int) -> Image:
    """Lines where what is seen ends, and where it stands before something else."""
    seen = np.isfinite(heights)
    filled = np.where(seen, heights, heights[seen].min(initial=0.0) - 10 * jump)
    bent = np.zeros(heights.shape)
    # The second difference is that of a step, not of a slope.
    bent[:, 1:-1] = np.abs(filled[:, 2:] - 2 * filled[:, 1:-1] + filled[:, :-2])
    bent[1:-1] = np.maximum(bent[1:-1], np.abs(filled[2:] - 2 * filled[1:-1] + filled[:-2]))
    strength = np.clip((bent / jump - 0.5) * 2, 0.0, 1.0)
    # A surface seen from its rim leaves single pixels of any depth; an edge is two pixels wide and long.
    strength[uniform_filter((strength > 0).astype(float), 3) < 3.5 / 9] = 0.0
    thick = strength.copy()
    for shift in range(1, max(1, finer // 2) + 1):
        for axis in (0, 1):
            for by in (-shift, shift):
                thick = np.maximum(thick, np.roll(strength, by, axis=axis))
    colour, opaque = np.array(to_rgb(edge[0])), edge[1] * thick
    out = image.copy()
    before = image[..., 3]
    out[..., 3] = np.maximum(before, opaque)
    share = np.where(before > 0, opaque, 1.0)[..., None]
    out[..., :3] = image[..., :3] * (1 - share) + colour * share
    return out


def shrunk(image: Image, finer: int) -> Image:
    """The mean of blocks of pixels, colours weighted by opacity."""
    rows, columns = image.shape[0] // finer, image.shape[1] // finer
    premultiplied = np.dstack([image[..., :3] * image[..., 3:], image[..., 3]])
    blocks = premultiplied[: rows * finer, : columns * finer].reshape(rows, finer, columns, finer, 4).mean(axis=(1, 3))
    opacity = blocks[..., 3:]
    return np.dstack(
        [np.divide(blocks[..., :3], opacity, out=np.zeros_like(blocks[..., :3]), where=opacity > 0), opacity]
    )


def faded(image: Image, opacity: float) -> Image:
    """An image that lets through what is behind it."""
    out = image.copy()
    out[..., 3] *= opacity
    return out
