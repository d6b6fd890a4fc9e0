"""What can be saved: pictures as the page shows them, the way as a film, the network with the present values, results, a report."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import viser

from .._errors import Error, NetworkError
from .._look import fields
from .._network import Network, loads
from .._network import _written as written
from .._toml import with_parameters
from .way import Way

if TYPE_CHECKING:
    from .session import Session

# Pixels of pictures and of films, height and width; pictures are drawn with so many times as many, which smoothes edges.
PICTURE, FILM, FINER = (1080, 1600), (540, 800), 2
FRAMES = 40
PATIENCE = 30.0


def action(session: Session, what: str, client: viser.ClientHandle) -> None:
    """Makes one of the files, and gives it to the browser."""
    note = client.add_notification("Saving", f"The {what} is being made.", loading=True, with_close_button=False)
    try:
        name, content = made(session, what, client)
    except (Error, RuntimeError, TimeoutError, ValueError, OSError) as error:
        note.loading, note.title, note.body, note.with_close_button = False, "Not saved", str(error), True
        return
    note.remove()
    client.send_file_download(name, content, save_immediately=True)
    client.flush()


def made(session: Session, what: str, client: viser.ClientHandle) -> tuple[str, bytes]:
    """The name and the content of a file."""
    stem = re.sub(r"[^\w.-]+", "_", session.name) or "network"
    present = session.network.set(**session.panel.values())
    if what == "picture":
        return f"{stem}.png", picture(session, client)
    if what == "film":
        return f"{stem}.gif", film(session, client)
    if what == "network":
        text, kind = network_file(session)
        return f"{stem}.{kind}", text.encode("utf-8")
    solution = present.solve(accuracy=session.accuracy)
    if what == "results":
        return f"{stem}.results.json", json.dumps(solution.to_dict(), indent=1).encode("utf-8")
    if what == "report":
        from .._report import page

        return f"{stem}.html", page(solution).encode("utf-8")
    raise ValueError(f"there is nothing called '{what}' to save")


def picture(session: Session, client: viser.ClientHandle) -> bytes:
    """What the browser shows, with the legend below."""
    from PIL import Image

    height, width = PICTURE
    pixels = client.get_render(FINER * height, FINER * width, transport_format="png", timeout=PATIENCE)
    image = with_legend(Image.fromarray(pixels).resize((width, height), Image.Resampling.LANCZOS), session)
    buffer = io.BytesIO()
    image.save(buffer, format="png", optimize=True)
    return buffer.getvalue()


def film(session: Session, client: viser.ClientHandle) -> bytes:
    """The way from unloaded to the end at the present values, seen from where the browser stands."""
    from PIL import Image

    way = Way(session.network.set(**session.panel.values()), session.accuracy)
    shown = np.unique(np.linspace(0, len(way.states), FRAMES).round().astype(int))
    before, images = session.display.shown, []
    for place in shown.tolist():
        session.display.draw(way.drawing(place - 1 if place else None), way.drawing(None))
        pixels = client.get_render(*FILM, transport_format="png", timeout=PATIENCE)
        images.append(with_legend(Image.fromarray(pixels), session).convert("RGB"))
    if before is not None:
        session.display.draw(*before)
    # One table of colours for all frames, so that nothing flickers.
    middle = Image.new("RGB", (images[0].width, 3 * images[0].height))
    for row, image in enumerate((images[0], images[len(images) // 2], images[-1])):
        middle.paste(image, (0, row * images[0].height))
    table = middle.quantize(255, method=Image.Quantize.MEDIANCUT)
    frames = [image.quantize(palette=table, dither=Image.Dither.NONE) for image in images]
    frames += [frames[-1]] * 10
    buffer = io.BytesIO()
    frames[0].save(buffer, format="gif", save_all=True, append_images=frames[1:], duration=70, loop=0, optimize=True)
    return buffer.getvalue()


def with_legend(image: Any, session: Session) -> Any:
    """The picture on white, with what the colours mean below."""
    from PIL import Image, ImageDraw, ImageFont

    scale = session.display.scale
    size = max(13, image.height // 40)
    page = Image.new("RGB", (image.width, image.height + 4 * size), "#ffffff")
    page.paste(image, (0, 0), image if image.mode == "RGBA" else None)
    if scale is None:
        return page
    pen, font = ImageDraw.Draw(page), ImageFont.load_default(size)
    left, top, wide = size, image.height + size // 2, page.width // 3
    words = scale.words().replace("\N{NO-BREAK SPACE}", " ").replace("\N{MINUS SIGN}", "-")
    pen.text((left, top), words, fill="#1a1d21", font=font)
    if not scale.uniform:
        values = np.linspace(scale.low, scale.high, wide)
        bar: npt.NDArray[np.uint8] = np.tile(scale.colours(values)[None], (size // 2, 1, 1))
        page.paste(Image.fromarray(bar), (left, top + round(1.4 * size)))
        for mark in scale.marks:
            place = left + wide * (mark - scale.low) / (scale.high - scale.low)
            text = fields.number(mark).replace("\N{MINUS SIGN}", "-")
            pen.text((place, top + 2 * size), text, fill="#1a1d21", font=font, anchor="ma")
    return page


def network_file(session: Session) -> tuple[str, str]:
    """The network with the present values: its own text where these can be put into it, else JSON. And the kind of the file."""
    values = session.panel.values()
    present = session.network.set(**values)
    named = {
        handle.name: present._stated(handle.name, float(f"{values[handle.name]:.10g}"))
        for handle in session.handles
        if handle.named
    }
    if not any(handle.value != values[handle.name] for handle in session.handles if not handle.named):
        path = session.source.path
        text = None
        if path is None or path.suffix != ".json":
            text = replaced(path.read_text(encoding="utf-8") if path is not None else session.network.text, named)
        if text is not None and same(text, present, session):
            return text, "toml"
    return written(present.to_dict()), "json"


def replaced(text: str, values: Mapping[str, float | str]) -> str | None:
    """A TOML text with other values of some parameters; nothing where it is no TOML."""
    from tomlkit.exceptions import TOMLKitError

    try:
        return with_parameters(text, values)
    except TOMLKitError:
        return None


def same(text: str, network: Network, session: Session) -> bool:
    """Whether a text is a network with the present values."""
    directory = session.source.path.parent if session.source.path is not None else ""
    try:
        found = loads(text, directory=directory)
    except NetworkError:
        return False
    return all(
        abs(found.parameters[name] - value) <= 1e-9 * max(abs(value), 1.0)
        for name, value in network.parameters.items()
        if name in found.parameters
    )
