"""Drives the live page and the report in a real browser, headless and with software WebGL, and prints what was measured.

    pip install 'bindings/python[view]' playwright
    python bindings/python/browser_check.py [--chromium /usr/bin/chromium] [--pictures docs/pictures] [NETWORK …]

Networks are `dyad`, `stage` and `spiral`, all by default. For each: seconds from the command to a page that can be used, in a
browser that runs already; milliseconds from a key on a slider to the number in the page, and the solver's part of them; frames a
second while the picture turns, and while the slider moves; whether the number is that of the solver, and whether the picture
changes. Then: a mistake in the file, pages of other origins, and the report. The exit status is 1 where something is wrong, but
not where it is slow: other work on the machine decides that too, so its load is printed with the figures. With `--pictures` the
screenshots of the book are made, and nothing is measured.
"""

from __future__ import annotations

import argparse
import functools
import http.server
import os
import pathlib
import statistics
import sys
import tempfile
import threading
import time
from typing import Any

from browser_page import FLAGS, changed, check, failures, numbers, opened, picture, served, slider, turned
from browser_saves import SNAP, gives_way, pointed, saves
from playwright.sync_api import Browser, Page, sync_playwright

import pennate
from pennate._view.follow import Follow
from pennate._view.handles import moving

MOVES = 40
# Milliseconds to the number and frames a second that are wanted, and what is moved.
NETWORKS: dict[str, tuple[dict[str, Any], str, int, int]] = {
    "dyad": ({"pressure": 20}, "chi", 60, 20),
    "stage": ({"beta": 32}, "beta", 100, 10),
    "spiral": ({"cells": 12}, "pressure", 100, 10),
}
START = 4.0
# From a key on the slider that has the focus to another number in the page.
MOVE = """([probe, key]) => new Promise((done) => {
  const now = () => document.querySelector(`[data-probe="${probe}"]`)?.dataset.value;
  const before = now(), begin = performance.now();
  const watch = new MutationObserver(() => { const value = now(); if (value !== undefined && value !== before) end(); });
  const late = setTimeout(() => end(true), 5000);
  function end(failed) { clearTimeout(late); watch.disconnect(); done(failed ? -1 : performance.now() - begin); }
  watch.observe(document.body, { subtree: true, childList: true, attributes: true, characterData: true });
  document.activeElement.dispatchEvent(new KeyboardEvent('keydown', { key, code: key, bubbles: true }));
})"""
# Moves the slider that has the focus for some seconds; gives the frames a second.
SLIDE = """(seconds) => new Promise((done) => {
  const slider = document.activeElement, begin = performance.now(), first = window.drawn;
  let key = 0;
  const timer = setInterval(() => { const name = (key++ / 12 | 0) % 2 ? 'ArrowRight' : 'ArrowLeft';
    slider.dispatchEvent(new KeyboardEvent('keydown', { key: name, code: name, bubbles: true })); }, 50);
  setTimeout(() => { clearInterval(timer);
    done((window.drawn - first) / ((performance.now() - begin) / 1000)); }, 1000 * seconds);
})"""


def solver_part(network: pennate.Network, name: str) -> float:
    """Milliseconds that the solver takes to follow one move of a slider, the median."""
    network, handles = moving(network, {})
    handle = next(each for each in handles if each.name == name)
    follow = Follow(network, tuple(each.name for each in handles))
    values = {each.name: each.value for each in handles}
    times = []
    for move in range(MOVES):
        values[name] = handle.value + handle.step * (1 + move % 5)
        begin = time.perf_counter()
        follow.go(values)
        times.append(1000 * (time.perf_counter() - begin))
    return statistics.median(times)


def measure(browser: Browser, folder: pathlib.Path, name: str) -> None:
    """All figures of one network."""
    settings, moved, wanted, frames = NETWORKS[name]
    network = pennate.scene(name, **settings)
    file = folder / f"{name}.toml"
    file.write_text(network.text, encoding="utf-8")
    print(
        f"{name}: {len(network.members)} members; load of the machine {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
    )
    with served(file) as (address, begin):
        page, start = opened(browser, address, begin)
        page.wait_for_timeout(1500)
        probe = next(iter(network.probes))
        thumb = slider(page, moved)
        thumb.focus()
        before = picture(page)
        times: list[float] = []
        for move in range(MOVES):
            times.append(page.evaluate(MOVE, [probe, "ArrowLeft" if move % 10 < 5 else "ArrowRight"]))
            page.wait_for_timeout(120)
        missed = sum(each < 0 for each in times)
        times = sorted(each for each in times if each >= 0)
        turning, each = turned(page, 4)
        page.wait_for_timeout(800)
        check(changed(before, picture(page)) > 0.01, "the picture turns")
        thumb.focus()
        sliding = page.evaluate(SLIDE, 4)
        before = picture(page)
        for _ in range(8):
            page.keyboard.press("ArrowLeft")
        page.wait_for_timeout(1500)
        value = float(thumb.get_attribute("aria-valuenow") or "nan")
        shown, exact = numbers(page), network.set(**{moved: value}).solve()
        part = solver_part(network, moved)
        print(f"  command to usable page  {start:6.2f} s     (wanted {START:g})")
        print(
            f"  slider to number        {statistics.median(times):6.0f} ms    (wanted {wanted}); least {times[0]:.0f}, nine of ten within {times[int(0.9 * len(times))]:.0f}; the solver's part {part:.2f} ms"
        )
        print(
            f"  frames a second         {turning:6.1f}       (wanted {frames}) as the picture turns, {sliding:.1f} as the slider moves"
        )
        print(f"  a frame                 {each:6.0f} ms    of the processors, all of the browser")
        check(missed == 0, "every key on the slider changes the number")
        for probe in network.probes:
            error, right = float(exact.error[probe][-1]), float(exact[probe][-1])
            near = abs(shown[probe] - right) <= 2 * max(error, 0.0) + 1e-9 * abs(shown[probe]) + 1e-9
            check(near, f"{probe} in the page {shown[probe]:.8g}, of the solver {right:.8g} ± {error:.1e}")
        check(
            changed(before, picture(page)) > 0.002,
            f"the picture changes: {100 * changed(before, picture(page)):.1f} % of its pixels",
        )
        check(
            not page.outside and not page.errors,
            f"no request to the outside, no error in the page {page.outside or ''}{page.errors or ''}",
        )  # type: ignore[attr-defined]
        pointed(page, name, network)
        if name == "dyad":
            saves(page, network.set(**{moved: value}))
            mistakes(page, file)
            strangers(browser, address)
        page.close()


def mistakes(page: Page, file: pathlib.Path) -> None:
    """A mistake in the file shows its message at its line, and the last good network stays."""
    before, text = numbers(page), file.read_text(encoding="utf-8")
    lines = text.splitlines()
    place = next(index for index, line in enumerate(lines) if "muscle = " in line)
    file.write_text("\n".join([*lines[:place], lines[place].replace("muscle = ", "muscel = "), *lines[place + 1 :]]))
    page.wait_for_selector("text=muscel", timeout=10_000)
    said = page.locator("pre").first.inner_text()
    check(f"dyad.toml:{place + 1}:" in said, f"a mistake shows its message at its line: {said.splitlines()[0]}")
    check(numbers(page) == before, "the last good network stays")
    file.write_text(text)
    page.wait_for_function("!document.body.innerText.includes('muscel')", timeout=10_000)
    check(True, "mended, the message is gone")


def snapping(browser: Browser, folder: pathlib.Path) -> None:
    """A state near its limit shows how it gives way."""
    file = folder / "strips.toml"
    file.write_text(SNAP)
    print("two strips near their limit")
    with served(file) as (address, begin):
        page, _ = opened(browser, address, begin)
        page.wait_for_timeout(1500)
        gives_way(page)
        page.close()


def strangers(browser: Browser, address: str) -> None:
    """A page of another origin gets neither the page nor its socket, even if it knows the address."""
    with tempfile.TemporaryDirectory() as folder:
        quiet = type("Quiet", (http.server.SimpleHTTPRequestHandler,), {"log_message": lambda *_: None})
        handler = functools.partial(quiet, directory=folder)
        (pathlib.Path(folder) / "index.html").write_text("<p>another page</p>")
        other = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=other.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{other.server_port}/")
        found = page.evaluate(
            """(address) => new Promise((done) => { const socket = new WebSocket(address.replace('http', 'ws').replace(/\\/$/, ''));
            socket.onopen = () => done('open'); socket.onerror = () => done('refused'); })""",
            address,
        )
        check(found == "refused", "a page of another origin may not open the socket")
        read = page.evaluate(
            "(address) => fetch(address).then((answer) => String(answer.status), () => 'refused')", address
        )
        check(read == "refused", "nor read the page")
        page.close()
        other.shutdown()
        other.server_close()


def report(browser: Browser, folder: pathlib.Path) -> None:
    """The report is drawn, moves, and asks for nothing."""
    file = folder / "report.html"
    pennate.scene("stage", beta=32).solve().report(file)
    print(f"report of the stage: {file.stat().st_size / 1e6:.2f} MB")
    page = browser.new_page(viewport={"width": 1000, "height": 900})
    asked: list[str] = []
    page.on("request", lambda each: asked.append(each.url))
    page.on("pageerror", lambda error: failures.append(str(error)))
    page.goto(file.as_uri())
    page.wait_for_timeout(800)
    before = picture(page)
    check(float((before.min(axis=2) < 200).mean()) > 0.02, "the picture shows the network")
    page.locator("#state").fill("1")
    page.wait_for_timeout(400)
    check(changed(before, picture(page)) > 0.005, "and moves along the way")
    box = page.locator("canvas").bounding_box()
    assert box is not None
    middle = picture(page)
    page.mouse.move(box["x"] + 300, box["y"] + 200)
    page.mouse.down()
    page.mouse.move(box["x"] + 420, box["y"] + 260, steps=5)
    page.mouse.up()
    page.wait_for_timeout(400)
    check(changed(middle, picture(page)) > 0.005, "and turns")
    check(asked == [file.as_uri()], "no request but that of the page itself")
    page.close()


def main() -> int:
    """The command line; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="*", help=f"of {', '.join(NETWORKS)}; all by default")
    parser.add_argument("--chromium", default="/usr/bin/chromium", help="the browser")
    parser.add_argument("--pictures", type=pathlib.Path, help="make the screenshots of the book in this folder")
    parsed = parser.parse_args()
    target = parsed.pictures.resolve() if parsed.pictures else None
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=parsed.chromium, args=FLAGS)
        print(f"Chromium {browser.version}, software WebGL; viser in its own process")
        if target is not None:
            from browser_pictures import draw

            draw(browser, pathlib.Path(folder), target)
        else:
            for name in parsed.names or NETWORKS:
                measure(browser, pathlib.Path(folder), name)
            snapping(browser, pathlib.Path(folder))
            report(browser, pathlib.Path(folder))
        browser.close()
    for each in failures:
        print(f"failed: {each}", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
