"""Draws all pictures of networks in the documentation, each from a network that it solves first.

    validation/.venv/bin/python validation/gallery.py PENNATE

PENNATE is the program, such as target/release/pennate. It draws docs/dyad.png, one picture a network into
docs/pictures/, and all scenes on one sheet, docs/scenes.png. Some have a picture for dark backgrounds too,
NAME-dark.png, without a background of its own. With names behind PENNATE these are drawn alone. What fails is named,
and the exit status is 1.
"""

from __future__ import annotations

import argparse
import dataclasses
import pathlib
import subprocess
import sys
import tempfile

from pictures import check, colours, figure, results, sheet, states, view

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
    parser.add_argument("pennate", type=pathlib.Path, help="the program")
    parser.add_argument("names", nargs="*", help=f"pictures to draw: {', '.join(PICTURES)}, scenes; all by default")
    arguments = parser.parse_args()
    names = arguments.names or [*PICTURES, "scenes"]
    wanted = [name for name in PICTURES if name in names or ("scenes" in names and PICTURES[name].tile)]
    complaints = check.listen_to_vtk()
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        solved = {}
        for name in wanted:
            try:
                solved[name] = solve(arguments.pennate, PICTURES[name], pathlib.Path(folder, name))
                if name in names:
                    draw(solved[name], PICTURES[name], name)
            except (subprocess.CalledProcessError, results.PictureError) as error:
                failed.append(f"{name}: {getattr(error, 'stderr', None) or error}")
        if "scenes" in names:
            tiles = {name: run for name, run in solved.items() if PICTURES[name].tile}
            draw_scenes(tiles)
    if complaints or failed:
        sys.exit("\n".join([*failed, *complaints]))


def solve(pennate: pathlib.Path, picture: Picture, folder: pathlib.Path) -> results.Run:
    """Solves a network into a folder, and reads the results."""
    folder.mkdir()
    settings = [word for setting in picture.settings for word in ("--set", setting)]
    network = picture.source
    if isinstance(network, str):
        network = folder / "scene.toml"
        network.write_text(call(pennate, "scene", picture.source, *settings), encoding="utf-8")
        settings = []
    call(pennate, "solve", network, *settings, "-o", folder, "--vtk", "ends")
    return results.read(folder)


def call(pennate: pathlib.Path, *arguments: object) -> str:
    """What the program prints."""
    command = [str(pennate.resolve()), *(str(argument) for argument in arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def draw(run: results.Run, picture: Picture, name: str) -> None:
    """One network, on white and perhaps on dark."""
    place = ROOT / "docs" / ("dyad.png" if name == "example" else f"pictures/{name}.png")
    place.parent.mkdir(exist_ok=True)
    for dark in (False, True)[: 1 + picture.dark]:
        options = states.Options(
            theme=colours.DARK if dark else colours.LIGHT,
            transparent=dark,
            field=picture.field,
            width=picture.width,
            steps=tuple(run.step_named(step) for step in picture.steps),
        )
        output = place.with_stem(f"{place.stem}-dark") if dark else place
        figure.draw(states.make_sheet(run, options, direction(run, picture)), options, output)


def direction(run: results.Run, picture: Picture) -> view.View:
    """The view that a picture asks for, or the usual one."""
    return view.view_named(picture.view or ("xy" if run.plane else "space"))


def draw_scenes(runs: dict[str, results.Run]) -> None:
    """All scenes on one sheet, on white and on dark."""
    for dark in (False, True):
        theme = colours.DARK if dark else colours.LIGHT
        tiles = []
        for name, run in runs.items():
            picture = PICTURES[name]
            step = run.step_named(picture.steps[-1]) if picture.steps else 0
            options = states.Options(theme=theme, transparent=dark, steps=(step,), names="none", resolution=155)
            settings = [setting for setting in picture.settings if not setting.startswith("pressure")]
            tiles.append(sheet.Tile(str(picture.source), " ".join(settings), run, options, direction(run, picture)))
        sheet.draw(tiles, theme, dark, ROOT / "docs" / f"scenes{'-dark' if dark else ''}.png")


if __name__ == "__main__":
    main()
