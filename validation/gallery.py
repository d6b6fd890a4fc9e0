"""Draws all pictures of networks in the documentation, each from a network that it solves first.

    validation/setup.sh && validation/.venv/bin/python validation/gallery.py

It draws docs/dyad.png, one picture a network into docs/pictures/, and all scenes on one sheet, docs/scenes.png. Some have
a picture for dark backgrounds too, NAME-dark.png, without a background of its own. With names behind it these are drawn
alone. What fails is named, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import dataclasses
import pathlib
import sys

import pennate
from check_vtu import listen_to_vtk
from pennate.pictures import api, figure, results, sheet, states

ROOT = pathlib.Path(__file__).resolve().parent.parent
NETWORKS = ROOT / "models" / "networks"


@dataclasses.dataclass(frozen=True)
class Picture:
    """What is drawn: a network file, or a scene with settings; the steps, or the ends of all; the field; the view."""

    source: pathlib.Path | str
    settings: tuple[str, ...] = ()
    steps: tuple[str, ...] = ()
    field: str = "axial_force"
    view: str = ""
    # Whether there is a picture for dark backgrounds too.
    dark: bool = False
    # Whether it stands on the sheet of all scenes.
    tile: bool = True
    # Width on paper, mm.
    width: float = 170.0


PICTURES = {
    # That of the README, docs/dyad.png.
    "example": Picture(NETWORKS / "dyad.toml", dark=True, tile=False),
    "tripod": Picture(NETWORKS / "tripod.toml", dark=True, tile=False, view="-35,24"),
    "stage_tip_tilt": Picture(
        NETWORKS / "tip_tilt_stage.toml", (), ("lower", "tilt"), dark=True, tile=False, view="-35,30"
    ),
    "muscle": Picture("muscle", (), ("load",), "bending_moment_3", tile=False, width=120.0),
    "dyad": Picture("dyad", ("pressure=20", "chi=26")),
    "conventional": Picture("conventional", ("n=2", "m=2", "pressure=20")),
    "inverted": Picture("inverted", ("n=3", "m=2", "pressure=20")),
    "hybrid": Picture("hybrid", ("n=2", "m=2", "pressure=20"), tile=False),
    "stage": Picture("stage", ("beta=32",), ("low", "one_high"), view="-35,30"),
    "sleeve_stroke": Picture("sleeve_stroke", width=110.0, view="-52,26"),
    "sleeve_compression": Picture("sleeve_compression", width=110.0, view="-52,26"),
    "spiral_cell": Picture("spiral", ("cells=1",), width=110.0),
    "spiral": Picture("spiral", ("cells=12",), width=130.0),
    "finger": Picture("finger", width=120.0),
    "wheel": Picture("wheel", ("press=0",), ("inflate", "stand on a load-bearing point")),
    "compliant_gripper": Picture("compliant_gripper", width=120.0),
    "motor": Picture("motor", width=120.0),
    "inverter": Picture("inverter", width=130.0),
    "wire_gripper": Picture("wire_gripper"),
    "morphing": Picture("morphing"),
    "ring_gripper": Picture("ring_gripper", width=130.0),
}


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help=f"pictures to draw: {', '.join(PICTURES)}, scenes; all by default")
    arguments = parser.parse_args()
    names = arguments.names or [*PICTURES, "scenes"]
    wanted = [name for name in PICTURES if name in names or ("scenes" in names and PICTURES[name].tile)]
    complaints = listen_to_vtk()
    failed = []
    solved = {}
    for name in wanted:
        try:
            solved[name] = solve(PICTURES[name])
            if name in names:
                draw(solved[name], PICTURES[name], name)
        except (pennate.Error, results.PictureError) as error:
            failed.append(f"{name}: {error}")
    if "scenes" in names:
        draw_scenes({name: run for name, run in solved.items() if PICTURES[name].tile})
    if complaints or failed:
        sys.exit("\n".join([*failed, *complaints]))


def solve(picture: Picture) -> results.Run:
    """Solves a network."""
    settings = dict(setting.split("=") for setting in picture.settings)
    if isinstance(picture.source, str):
        network = pennate.scene(picture.source, **settings)
    else:
        network = pennate.load(picture.source, **settings)
    return results.of(network.solve().raise_for_status())


def draw(run: results.Run, picture: Picture, name: str) -> None:
    """One network, on white and perhaps on dark."""
    place = ROOT / "docs" / ("dyad.png" if name == "example" else f"pictures/{name}.png")
    place.parent.mkdir(exist_ok=True)
    for dark in (False, True)[: 1 + picture.dark]:
        options = api.options(
            run, picture.steps, dark=dark, transparent=dark, field=picture.field, width=picture.width
        )
        output = place.with_stem(f"{place.stem}-dark") if dark else place
        figure.draw(states.make_sheet(run, options, api.direction(run, picture.view)), options, output)


def draw_scenes(runs: dict[str, results.Run]) -> None:
    """All scenes on one sheet, on white and on dark."""
    for dark in (False, True):
        tiles = []
        for name, run in runs.items():
            picture = PICTURES[name]
            step = picture.steps[-1] if picture.steps else 0
            options = api.options(run, [step], dark=dark, transparent=dark, names="none", resolution=155)
            settings = [setting for setting in picture.settings if not setting.startswith("pressure")]
            tiles.append(sheet.Tile(str(picture.source), " ".join(settings), run, options, api.direction(run, picture.view)))
        sheet.draw(tiles, tiles[0].options.theme, dark, ROOT / "docs" / f"scenes{'-dark' if dark else ''}.png")


if __name__ == "__main__":
    main()
