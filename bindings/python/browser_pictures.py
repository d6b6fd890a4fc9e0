"""The screenshots of the book; see browser_check.py, which starts the browser."""

from __future__ import annotations

import io
import pathlib
from typing import Any

from browser_page import opened, served, slider
from browser_saves import SNAP
from PIL import Image
from playwright.sync_api import Browser, Page

import pennate

ROOT = pathlib.Path(__file__).resolve().parents[2]
SIZE = (1200, 760)
# Pages are drawn with so many times as many pixels, which smoothes edges without a GPU.
FINER = 2


def draw(browser: Browser, folder: pathlib.Path, target: pathlib.Path) -> None:
    """All of them."""
    target.mkdir(exist_ok=True)
    (folder / "stage.toml").write_text(pennate.scene("stage", beta=32).text)
    (folder / "dyad.toml").write_text((ROOT / "models/networks/dyad.toml").read_text())
    (folder / "strips.toml").write_text(SNAP)
    with served(folder / "stage.toml") as (address, _):
        page = fresh(browser, address)
        moved(page, "beta", "ArrowLeft", 12)
        save(page, target / "view-stage.png")
        page.close()
    with served(folder / "strips.toml", "--range", "F=0:100") as (address, _):
        page = fresh(browser, address)
        moved(page, "F", "ArrowRight", 36)
        moved(page, "F", "ArrowLeft", 60)
        save(page, target / "view-snap.png")
        page.close()
    with served(folder / "dyad.toml") as (address, _):
        page = fresh(browser, address)
        text = (folder / "dyad.toml").read_text()
        (folder / "dyad.toml").write_text(text.replace('muscle = "silicone"', 'muscle = "silicon"', 1))
        page.wait_for_selector("pre")
        page.wait_for_timeout(1500)
        save(page, target / "view-mistake.png")
        page.close()
    pennate.load(ROOT / "models/networks/tip_tilt_stage.toml").solve().report(folder / "report.html")
    page = browser.new_page(viewport={"width": 900, "height": 1040}, device_scale_factor=FINER)
    page.goto((folder / "report.html").as_uri())
    page.wait_for_timeout(1500)
    save(page, target / "report.png")
    page.close()


def fresh(browser: Browser, address: str) -> Page:
    """A page without the notice that there is no GPU."""
    page, _ = opened(browser, address, size=SIZE, finer=FINER)
    page.wait_for_timeout(1500)
    if page.locator("text=Software WebGL").count():
        page.locator(".mantine-Notification-closeButton").first.click()
        page.wait_for_timeout(800)
    return page


def moved(page: Page, label: str, key: str, times: int) -> None:
    """A slider by some places, and until everything is shown."""
    thumb: Any = slider(page, label)
    thumb.focus()
    for _ in range(times):
        page.keyboard.press(key)
        page.wait_for_timeout(60)
    page.wait_for_timeout(4000)


def save(page: Page, output: pathlib.Path) -> None:
    """A screenshot in 256 colours, which nobody tells from all of them."""
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    image = image.resize((image.width // FINER, image.height // FINER), Image.Resampling.LANCZOS)
    image.quantize(256, kmeans=3, dither=Image.Dither.NONE).save(output, optimize=True)
    print(f"{output.name}: {output.stat().st_size / 1000:.0f} kB")
