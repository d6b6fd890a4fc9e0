"""What is asked for, read off the tables of the page, and which of it is not reached."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from . import table

WITHIN, MOVES, ERROR = "within 1.5 cm, %", "moves", "error, cm"
BEYOND = "beyond the closest reachable point, cm"


@dataclass(frozen=True)
class Bar:
    """One figure: the mean, where a spread is printed beside it."""

    section: str
    row: str
    """The first cells of the row, with commas between them."""
    column: str
    least: float | None = None
    most: float | None = None
    less: str = ""
    """A column that is subtracted."""
    below: str = ""
    """A row of the same table that has a greater figure."""


def _bars() -> Iterator[Bar]:
    yield from _pairs()
    for waypoints in ("extremal", "lateral sweep"):
        for place in range(1, 6):
            yield Bar("fig34", f"{waypoints}, DQN", f"{place}", most=1.0)
    for strides in ("all strides", "the smallest alone"):
        yield Bar("fig35", strides, "ratio, of those", most=1.5)
        yield Bar("fig35", strides, "there in 160, %", least=100.0)
    for point in ("2, 9 g", "3, 9 g", "2, 12 g", "3, 12 g"):
        yield Bar("table9", point, "closest reachable", most=0.3, least=-0.3, less="reported")
        for which in ("DQN, closest of the run", "DQN, last"):
            yield Bar("table9", point, which, most=0.35, less="closest reachable")
    yield from _curves()
    yield Bar("fig40", "DDPG, closest of the run", BEYOND, most=1.2)
    yield Bar("fig40", "DDPG, closest of the run", "this below the perturbation, %", least=95.0)
    yield Bar("fig40", "with restarts", BEYOND, most=0.1)
    yield Bar("fig41", "DDPG", WITHIN, least=99.0)
    yield Bar("fig41", "DDPG", MOVES, most=5.0)


def _pairs() -> Iterator[Bar]:
    """Table 8, and the same with three inputs."""
    for load, share in {0: 97.3, 6: 97.2, 9: 96.0, 12: 96.0, 18: 94.6}.items():
        yield Bar("table8", f"{load} g, DQN", WITHIN, least=share)
        yield Bar("table8", f"{load} g, DQN", MOVES, most=9.0)
        for way in ("Gauss–Newton", "with restarts"):
            yield Bar("table8", f"{load} g, {way}", WITHIN, least=99.8)
            yield Bar("table8", f"{load} g, {way}", MOVES, most=6.0)
    for load, share in {0: 99.0, 3: 99.0, 6: 99.0, 9: 98.5}.items():
        yield Bar("three", f"{load} g, DDPG", WITHIN, least=share)
        yield Bar("three", f"{load} g, DDPG", ERROR, most=0.8)
        yield Bar("three", f"{load} g, DDPG", MOVES, most=3.0)
    for section, policy, loads in (("table8", "DQN", (0, 6, 9, 12, 18)), ("three", "DDPG", (0, 3, 6, 9))):
        for load in loads:
            yield Bar(section, f"{load} g, hybrid", WITHIN, least=99.9)
            for way in (policy, "Gauss–Newton"):
                yield Bar(section, f"{load} g, hybrid", MOVES, below=f"{load} g, {way}")


def _curves() -> Iterator[Bar]:
    """Tables 11 and 12."""
    for name, without, loaded in (("line", 0.83, 1.0), ("circle", 0.71, 1.0), ("Viviani, pressed", 0.93, 1.37)):
        yield Bar("table11", f"{name}, 0 g", "DDPG to 1.5 cm", most=without)
        yield Bar("table11", f"{name}, 9 g", "DDPG to 1.5 cm", most=loaded)
        for load in (0, 3, 6, 9):
            yield Bar("table11", f"{name}, {load} g", "with restarts, to 0.1 cm", most=0.1)
        yield Bar("table12", f"{name}, open", "open loop", least=3.0, most=6.0)
        for load, most in ((0, 1.0), (9, 1.1)):
            yield Bar("table12", f"{name}, {load} g", "DDPG to 1.5 cm", most=most)
            yield Bar("table12", f"{name}, {load} g, worse arm", "DDPG to 1.5 cm", most=1.3)
            yield Bar("table12", f"{name}, {load} g", "feedback, to 0.3 cm", most=0.5)
            yield Bar("table12", f"{name}, {load} g, worse arm", "feedback, to 0.3 cm", most=1.3)


def missed(sections: Mapping[str, str]) -> str:
    """A table of the figures that miss their bars, by the texts of sections; those that are not there are left out."""
    rows, held = [], 0
    tables = {name: _rows(text) for name, text in sections.items()}
    bars = [bar for bar in _bars() if tables.get(bar.section)]
    for bar in bars:
        reached, asked, good = _judged(bar, tables[bar.section])
        held += good
        if not good:
            rows.append([bar.section, bar.row, bar.column + (f" less {bar.less}" if bar.less else ""), reached, asked])
    if not bars:
        return ""
    text = f"{held} of {len(bars)} figures are reached."
    head = ["section", "row", "figure", "reached", "asked for"]
    return text if not rows else f"{text}\n\n{table('Missed', head, rows)}"


def _judged(bar: Bar, rows: Mapping[str, Mapping[str, str]]) -> tuple[str, str, bool]:
    """What is reached and asked for, and whether the one is as good as the other."""
    cells = _found(bar.row, rows)
    value, shown = _mean(cells[bar.column]), cells[bar.column]
    if bar.less:
        value -= _mean(cells[bar.less])
        shown = f"{value:.2f}"
    if bar.below:
        other = _found(bar.below, rows)[bar.column]
        return shown, f"below {other}, {bar.below}", value < _mean(other)
    limits = [("≥", bar.least), ("≤", bar.most)]
    asked = " and ".join(f"{sign} {limit:g}" for sign, limit in limits if limit is not None)
    good = (bar.least is None or value >= bar.least - 1e-9) and (bar.most is None or value <= bar.most + 1e-9)
    return shown, asked, good


def _found(start: str, rows: Mapping[str, Mapping[str, str]]) -> Mapping[str, str]:
    return next(cells for row, cells in rows.items() if row.startswith(f"{start}, "))


def _mean(cell: str) -> float:
    return float(cell.split(" ± ")[0])


def _rows(text: str) -> dict[str, dict[str, str]]:
    """Rows of a table by their cells with commas between them; cells by columns, of columns of one name the first."""
    lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in text.splitlines() if line.startswith("| ")]
    if not lines:
        return {}
    head, *rows = lines
    return {", ".join(row): dict(zip(reversed(head), reversed(row))) for row in rows}
