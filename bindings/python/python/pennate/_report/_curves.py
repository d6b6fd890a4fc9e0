"""Curves as pictures of their own, in SVG: probes along the way through the steps."""

from __future__ import annotations

import html

import numpy as np

from .._look.fields import Array, number, ticks

WIDE, HIGH = 300.0, 180.0
LEFT, RIGHT, ABOVE, BELOW = 52.0, 10.0, 10.0, 22.0
INK, FAINT, RULE = "#245f97", "#5b6470", "#d8dde3"


def curve(x: Array, y: Array, names: list[str], ends: list[int], title: str) -> str:
    """One probe over the way: whole numbers are the ends of steps, named below; dots are at these ends."""
    known = np.isfinite(y)
    if not known.any():
        return ""
    marks = ticks(float(y[known].min()), float(y[known].max()))
    if len(marks) == 1:
        reach = 0.5 * abs(marks[0]) or 1.0
        marks = (marks[0] - reach, marks[0], marks[0] + reach)
    low, high = marks[0], marks[-1]
    across = max(float(x.max()), 1e-12)
    low_x = min(0.0, float(x.min()))

    def place(a: float, b: float) -> tuple[float, float]:
        right = LEFT + (WIDE - LEFT - RIGHT) * (a - low_x) / (across - low_x)
        return right, HIGH - BELOW - (HIGH - ABOVE - BELOW) * (b - low) / (high - low)

    parts = [f'<svg viewBox="0 0 {WIDE:g} {HIGH:g}" width="{WIDE:g}" height="{HIGH:g}" role="img">']
    parts.append(f"<title>{html.escape(title)}</title>")
    for mark in marks:
        _, top = place(0.0, mark)
        parts.append(f'<line x1="{LEFT:g}" y1="{top:.1f}" x2="{WIDE - RIGHT:g}" y2="{top:.1f}" stroke="{RULE}"/>')
        parts.append(text(LEFT - 5, top + 3.5, number(mark), "end"))
    for step, name in enumerate(names):
        begin, end = place(float(step), low)[0], place(float(step + 1), low)[0]
        if begin > WIDE - RIGHT - 2:
            break
        parts.append(
            f'<line x1="{end:.1f}" y1="{ABOVE:g}" x2="{end:.1f}" y2="{HIGH - BELOW:g}" stroke="{RULE}" stroke-dasharray="3 3"/>'
        )
        room = max(3, int((min(end, WIDE) - begin) / 6.0))
        short = name if len(name) <= room else name[: room - 1] + "…"
        parts.append(text((begin + min(end, WIDE - RIGHT)) / 2, HIGH - BELOW + 15, short, "middle"))
    way = " ".join(f"{a:.1f},{b:.1f}" for a, b in (place(float(a), float(b)) for a, b in zip(x[known], y[known])))
    parts.append(f'<polyline points="{way}" fill="none" stroke="{INK}" stroke-width="1.8" stroke-linejoin="round"/>')
    for row in ends:
        if np.isfinite(y[row]):
            a, b = place(float(x[row]), float(y[row]))
            parts.append(f'<circle cx="{a:.1f}" cy="{b:.1f}" r="3" fill="{INK}"/>')
    parts.append("</svg>")
    return f"<figure>{''.join(parts)}<figcaption>{html.escape(title)}</figcaption></figure>"


def text(x: float, y: float, words: str, anchor: str) -> str:
    """A word at a place."""
    return f'<text x="{x:.1f}" y="{y:.1f}" font-size="10.5" fill="{FAINT}" text-anchor="{anchor}">{html.escape(words)}</text>'


def still(drawing_lines: Array, colours: list[str], widths: Array, frame: tuple[float, float, float, float]) -> str:
    """A picture that needs no WebGL: lines on paper, (n, 2, 2), with their colours and widths, in units of the network."""
    left, bottom, wide, high = frame
    parts = [
        f'<svg viewBox="{left:.5g} {-bottom - high:.5g} {wide:.5g} {high:.5g}" width="100%" style="max-height:34rem" role="img">'
    ]
    for (start, end), colour, width in zip(drawing_lines, colours, widths):
        parts.append(
            f'<line x1="{start[0]:.5g}" y1="{-start[1]:.5g}" x2="{end[0]:.5g}" y2="{-end[1]:.5g}" '
            f'stroke="{colour}" stroke-width="{width:.4g}" stroke-linecap="round"/>'
        )
    return "".join([*parts, "</svg>"])
