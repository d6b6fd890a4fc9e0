"""Drives a page in a headless Chromium, for the checks and pictures beside."""

from __future__ import annotations

import contextlib
import io
import pathlib
import subprocess
import sys
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser, Page

FLAGS = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist", "--no-sandbox"]
# Counts animation frames in which something was drawn.
COUNT = """
window.drawn = 0; window.fresh = false;
for (const name of ['drawElements', 'drawElementsInstanced', 'drawArrays']) {
  const real = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (...all) { window.fresh = true; return real.apply(this, all); };
}
(function tick() { if (window.fresh) { window.drawn += 1; window.fresh = false; } requestAnimationFrame(tick); })();
"""

failures: list[str] = []


def check(good: bool, what: str) -> None:
    """Notes what is wrong."""
    print(f"  {'yes' if good else 'NO '}  {what}")
    if not good:
        failures.append(what)


@contextlib.contextmanager
def served(file: pathlib.Path, *options: str) -> Iterator[tuple[str, float]]:
    """The page of a file by the command; its address, and when the command was given."""
    command = [
        sys.executable,
        "-W",
        "error",
        "-m",
        "pennate",
        "view",
        str(file),
        "--no-browser",
        "--port",
        "8600",
        *options,
    ]
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None and process.stderr is not None
        address = process.stdout.readline().strip()
        if not address:
            raise RuntimeError(process.stderr.read())
        yield address, begin
    finally:
        process.terminate()
        said = process.communicate(timeout=20)[1]
        check(not said, f"nothing on standard error{': ' + said if said else ''}")


def opened(
    browser: Browser, address: str, begin: float | None = None, size: tuple[int, int] = (1280, 800), finer: int = 1
) -> tuple[Page, float]:
    """The page, when its numbers and its picture are there; and the seconds since then."""
    page = browser.new_page(viewport={"width": size[0], "height": size[1]}, device_scale_factor=finer)
    page.set_default_timeout(120_000)
    page.add_init_script(COUNT)
    outside: list[str] = []
    page.on("request", lambda each: outside.append(each.url) if not inside(each.url, address) else None)
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.outside, page.errors = outside, errors  # type: ignore[attr-defined]
    page.goto(address)
    page.wait_for_function("document.querySelector('[data-probe]') && window.drawn > 2", timeout=60_000)
    return page, time.perf_counter() - (begin or time.perf_counter())


def inside(url: str, address: str) -> bool:
    """Whether a request stays on the page."""
    return url.startswith((address, "data:", "blob:", address.replace("http", "ws").rstrip("/")))


def picture(page: Page) -> np.ndarray[Any, Any]:
    """The pixels of the canvas."""
    shot = page.locator("canvas").first.screenshot()
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


def changed(before: np.ndarray[Any, Any], after: np.ndarray[Any, Any]) -> float:
    """Part of the pixels that are different."""
    return float((np.abs(before - after).max(axis=2) > 24).mean())


def spent(page: Page) -> float:
    """Processor time that all processes of the browser have used, in seconds."""
    assert page.context.browser is not None
    session = page.context.browser.new_browser_cdp_session()
    found = session.send("SystemInfo.getProcessInfo")["processInfo"]
    session.detach()
    return float(sum(each["cpuTime"] for each in found))


def turned(page: Page, seconds: float) -> tuple[float, float]:
    """Turns the picture by the mouse for some seconds; gives the frames a second, and the processor time of each in ms."""
    before = spent(page)
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    x, y = box["x"] + 0.4 * box["width"], box["y"] + 0.6 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 5, y, steps=2)
    begin, first, move = time.perf_counter(), page.evaluate("window.drawn"), 0
    while time.perf_counter() - begin < seconds:
        move += 1
        page.mouse.move(x + 60 * np.sin(0.12 * move), y)
    frames, took = page.evaluate("window.drawn") - first, time.perf_counter() - begin
    used = spent(page) - before
    page.mouse.move(x + 150, y)
    page.mouse.up()
    return frames / took, 1000 * used / max(frames, 1)


def slider(page: Page, label: str) -> Any:
    """The slider with a name."""
    place = page.evaluate(
        """(label) => { const all = [...document.querySelectorAll('[role=slider]')];
        return all.findIndex((one) => { let node = one; for (let i = 0; i < 9 && node; i++, node = node.parentElement)
          if ([...node.querySelectorAll('label')].some((each) => each.textContent.trim() === label)
              && node.querySelectorAll('[role=slider]').length === 1) return true; return false; }); }""",
        label,
    )
    if place < 0:
        raise LookupError(f"there is no slider '{label}'")
    return page.locator("[role=slider]").nth(place)


def numbers(page: Page) -> dict[str, float]:
    """What the page shows."""
    found = page.evaluate(
        "Object.fromEntries([...document.querySelectorAll('[data-probe]')].map((e) => [e.dataset.probe, e.dataset.value]))"
    )
    return {name: float(value) for name, value in found.items()}
