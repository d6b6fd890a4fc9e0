"""Films: one state a frame, all with one frame, one scale and one legend."""

from __future__ import annotations

import dataclasses
import pathlib
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from PIL import Image

from .._look.finer import finer as way
from . import figure, paper, states
from .results import PictureError, Run
from .view import View

if TYPE_CHECKING:
    from .._solution import Solution

# The last frame of a film stands so long, in frames.
REST = 12
# How a film looks where nothing else is asked for: width on paper in millimetres, pixels an inch, names.
LOOKS: dict[str, object] = {"width": 140.0, "resolution": 90, "names": "none"}


def check(output: pathlib.Path) -> None:
    """Refuses what is no film before anything is drawn."""
    if output.suffix.lower() not in (".gif", ".mp4"):
        raise PictureError(f"{output}: a film is a .gif or an .mp4")


def finer(solution: Solution, frames: int) -> Solution:
    """The same solution with at least so many increments a step, where the network gives it again."""
    if frames < 1:
        raise PictureError(f"frames: at least one a step, not {frames}")
    return way(solution, frames, max(solution.asked, 1e-4))


def draw(run: Run, options: states.Options, view: View, output: pathlib.Path, seconds: float) -> None:
    """Draws all states of a run into a file."""
    moving = [state for state in run.states if state.step is not None]
    if not moving:
        raise PictureError("no step was reached: there is nothing to show")
    together = states.make_sheet(run, options, view, states=[run.state_after(None), *moving])
    still = dataclasses.replace(together.panels[0], title=together.panels[1].title)
    panels = [still, *together.panels[1:]]
    pictures = []
    for panel in panels:
        made = figure.make(dataclasses.replace(together, panels=(panel,)), options)
        pictures.append(paper.pixels_of(made)[..., :3].copy())
    shape = np.min([picture.shape[:2] for picture in pictures], axis=0)
    pictures = [picture[: shape[0], : shape[1]] for picture in pictures]
    pictures += [pictures[-1]] * REST
    rate = len(moving) / (seconds * len({state.step for state in moving}))
    save_gif(pictures, output, rate) if output.suffix.lower() == ".gif" else save_mp4(pictures, output, rate)


def save_gif(pictures: list[npt.NDArray[np.uint8]], output: pathlib.Path, rate: float) -> None:
    """Colours of all frames from one table, so that nothing flickers."""
    middle = Image.fromarray(np.concatenate([pictures[0], pictures[len(pictures) // 2], pictures[-1]]))
    table = middle.quantize(255, method=Image.Quantize.MEDIANCUT)
    images = [Image.fromarray(each).quantize(palette=table, dither=Image.Dither.NONE) for each in pictures]
    images[0].save(output, save_all=True, append_images=images[1:], duration=round(1000 / rate), loop=0, optimize=True)


def save_mp4(pictures: list[npt.NDArray[np.uint8]], output: pathlib.Path, rate: float) -> None:
    """H.264, whose frames have an even number of pixels a side."""
    import imageio.v3

    rows, columns = (size - size % 2 for size in pictures[0].shape[:2])
    frames = np.stack([each[:rows, :columns] for each in pictures])
    imageio.v3.imwrite(output, frames, fps=rate, codec="libx264", macro_block_size=2, output_params=["-crf", "18"])
