"""What a person does besides moving sliders: pointing, letting a state give way, saving. See browser_check.py."""

from __future__ import annotations

import io
import json
import pathlib
import time

import numpy as np
from browser_page import changed, check, picture
from PIL import Image
from playwright.sync_api import Page

import pennate

# Two strips that snap where F passes 65.6 N.
SNAP = """\
format = "pennate/1"
title = "two strips"
dimension = "plane"
parameters = { F = 50 }
nodes = { A = [-100, 0], B = [100, 0], C = [0, 10] }
materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
sections.strip = { rectangle = { width = 10, height = 1 } }
members.left = { nodes = ["A", "C"], section = "strip", material = "steel" }
members.right = { nodes = ["B", "C"], section = "strip", material = "steel" }
supports = { A = "clamped", B = "clamped" }
probes.down = { node = "C", displacement = "uy" }
[[steps]]
name = "press"
force = { C = [0, "= -F"] }
"""


def pointed(page: Page, name: str, network: pennate.Network) -> None:
    """What the pointer is on is named: along the lines of the picture each member in turn."""
    page.wait_for_function("document.querySelector('[data-pn-places]')?.dataset.pnPlaces.length > 2")
    box = page.locator("canvas").first.bounding_box()
    assert box is not None
    found = set()
    for place in np.random.default_rng(1).uniform(0.2, 0.8, (120, 2)):
        page.mouse.move(box["x"] + place[0] * box["width"], box["y"] + place[1] * box["height"])
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        label = page.locator("#pn-name")
        if label.is_visible():
            found.add(label.inner_text().removeprefix("node ").split(":")[0])
    known = {*network.members, *network.nodes}
    check(bool(found) and found <= known, f"the pointer is told what it is on: {', '.join(sorted(found)[:4])} …")


def gives_way(page: Page) -> None:
    """The mode in which the state gives way is said and moves."""
    page.get_by_role("button", name="Show how it gives way").click()
    page.wait_for_selector("text=How it gives way: it would at", timeout=60_000)
    first, most = picture(page), 0.0
    for _ in range(6):
        page.wait_for_timeout(150)
        most = max(most, changed(first, picture(page)))
    check(most > 0.002, f"the mode moves: {100 * most:.1f} % of the pixels")
    page.wait_for_selector("text=Stable", timeout=60_000)


def saves(page: Page, network: pennate.Network) -> None:
    """Everything that can be saved comes as a file that holds what the page shows."""
    page.get_by_text("Save", exact=True).click()
    page.wait_for_timeout(600)

    def saved(label: str) -> tuple[str, bytes, float]:
        begin = time.perf_counter()
        with page.expect_download(timeout=120_000) as download:
            page.get_by_role("button", name=label, exact=True).click()
        return download.value.suggested_filename, pathlib.Path(download.value.path()).read_bytes(), time.perf_counter() - begin

    name, content, seconds = saved("Picture")
    image = Image.open(io.BytesIO(content)).convert("RGB")
    # The network alone, without the legend below.
    drawn = float((np.asarray(image)[:1080].min(axis=2) < 200).mean())
    check(name.endswith(".png") and drawn > 0.01, f"{name}, {image.width} by {image.height}, {100 * drawn:.0f} % drawn, {seconds:.1f} s")
    name, content, seconds = saved("GIF of the way")
    film = Image.open(io.BytesIO(content))
    frames = []
    for frame in range(getattr(film, "n_frames", 1)):
        film.seek(frame)
        frames.append(np.asarray(film.convert("RGB")).astype(int))
    moves = sum(changed(*each) > 0 for each in zip(frames, frames[1:], strict=False))
    check(moves > 20, f"{name}, {len(frames)} pictures, {moves} of them others than before, {len(content) / 1e6:.1f} MB, {seconds:.1f} s")
    name, content, seconds = saved("Network file with these values")
    again = pennate.loads(content.decode()) if name.endswith(".toml") else pennate.Network(json.loads(content))
    check(again.parameters == network.parameters, f"{name} has the present values")
    name, content, seconds = saved("Results")
    exact = network.solve().to_dict()
    check(json.loads(content)["steps"][-1]["probes"] == exact["steps"][-1]["probes"], f"{name} has the results of these values")
    name, content, seconds = saved("Report")
    check(name.endswith(".html") and b"</html>" in content, f"{name}, {len(content) / 1e6:.1f} MB, {seconds:.1f} s")
