"""What happens: sliders move, the state follows, pictures and numbers with it; the file is read again when it changes."""

from __future__ import annotations

import collections
import os
import pathlib
import threading
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser

from .._errors import Error
from .._look import carry, fields, words
from .._look.fields import Array, Scale
from .._network import EDITED, Network, load
from . import save
from .follow import Follow, Now, Probe
from .handles import Handle, moving, pressure_units
from .panel import GRID, Panel
from .picture import Picture, line_values
from .server import LOOPBACK, Server
from .way import Way

# Seconds between two looks at the file, and of rest before a curve is drawn.
WATCH, REST = 0.25, 0.25
# Shapes that take longer are shown as carried ones first, in seconds.
QUICK = 0.015
# A film of a snap or of a mode, in seconds and frames a second.
SNAP, MODE, RATE = 0.6, 2.4, 25.0
UNITS = {"mm-N-MPa": ("mm", "N"), "m-N-Pa": ("m", "N")}
STAYED = (
    "Shapes between nodes are carried along from the last one that was computed; the numbers are those of the state."
)
SNAPPED = "It lost its stability on the way and snapped: shown is where the steps of the file lead at these values if they may snap. The motion between the two states is drawn, not computed."


class Session:
    """One network, or one file, shown to whoever has the address."""

    def __init__(
        self,
        network: Network,
        path: pathlib.Path | None = None,
        *,
        settings: Mapping[str, str] | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        accuracy: float = 1e-6,
        port: int = 8080,
        bind: str = LOOPBACK,
        hosts: Sequence[str] = (),
    ) -> None:
        self.path, self.settings, self.ranges, self.accuracy = path, dict(settings or {}), dict(ranges or {}), accuracy
        self.lock, self.wake = threading.RLock(), threading.Condition()
        self.stopped, self.dirty, self.looked, self.moved = False, True, False, ""
        # What is asked for is counted, and what is answered.
        self.asked, self.answered = 1, 0
        self.actions: collections.deque[tuple[str, viser.ClientHandle | None]] = collections.deque()
        self.seen = self._stamp()
        self.times: dict[str, float] = {}
        network, self.handles = moving(network, self.ranges)
        self._take(network, self.handles)
        self.server = Server(port, self.name, bind, hosts)
        self.fields = self._fields()
        self.panel = Panel(self.server, self.name, self.fields)
        self.panel.on_values, self.panel.on_step = self._values_moved, self._ask
        self.panel.on_look, self.panel.on_action = self._look, self._act
        self._show_network()
        self.server.scene.on_click()(self._clicked)
        self.worker = threading.Thread(target=self._work, name="pennate view", daemon=True)
        self.worker.start()

    # The network.

    @property
    def name(self) -> str:
        """What the page is called."""
        return self.network.title or pathlib.PurePath(self.network.name).name.removesuffix(EDITED)

    def _take(self, network: Network, handles: list[Handle]) -> None:
        self.network, self.handles = network, handles
        self.follows: dict[int, Follow] = {}
        self.way: tuple[tuple[float, ...], Way] | None = None
        self.now: Now | None = None
        self.scale: Scale | None = None
        self.visited: collections.deque[tuple[float, float]] = collections.deque(maxlen=200)
        self.curve: tuple[Any, Array, Array] | None = None
        self.shown: tuple[dict[str, Any], dict[str, Any]] | None = None
        self.judged = "space"
        self.snapped = False

    def _fields(self) -> dict[str, fields.Field]:
        """What can be shown, in the units of the network."""
        units = pressure_units(self.network.to_dict())
        return fields.fields(*UNITS[self.network.units], units.pop() if len(units) == 1 else "")

    def _about(self) -> str:
        """The file and what it holds, in a line."""
        name = pathlib.PurePath(self.network.name).name.removesuffix(EDITED)
        kind = "plane" if self.network.dimension == "plane" else "spatial"
        count = len(self.network.members)
        return f"{name} · {kind}, {len(self.network.nodes)} nodes, {count} {'member' if count == 1 else 'members'}"

    def _show_network(self) -> None:
        self.fields = self.panel.fields = self._fields()
        self.panel.title(self.name, self._about())
        self.panel.set_handles(self.handles, self.network.steps)
        self.panel.set_probes(tuple(self.network.probes))
        joined = self._follow(len(self.network.steps)).joined
        self.picture = Picture(
            self.server, self.network.nodes, self.network.members, joined, self.network.dimension == "plane"
        )
        if not self.picture.with_names:
            self.panel.names.value = False
        self.moved = self.handles[0].name if self.handles else ""

    def _follow(self, step: int) -> Follow:
        """What follows the state at the end of a step, which is counted from one."""
        if step not in self.follows:
            names = tuple(handle.name for handle in self.handles)
            self.follows[step] = Follow(self.network, names, step - 1, self.accuracy)
        return self.follows[step]

    # What a person does.

    def _values_moved(self, name: str) -> None:
        if name != self.moved:
            self.moved = name
            self.visited.clear()
            self.curve = None
        self._ask()

    def _ask(self) -> None:
        with self.wake:
            self.dirty = True
            self.asked += 1
            self.wake.notify()

    def _look(self) -> None:
        with self.wake:
            self.looked = True
            self.asked += 1
            self.wake.notify()

    def _act(self, action: str, client: viser.ClientHandle | None) -> None:
        with self.wake:
            self.actions.append((action, client))
            self.asked += 1
            self.wake.notify()

    def _clicked(self, event: Any) -> None:
        """Says all values of the member that was clicked."""
        member = self.picture.member_along(np.array(event.ray_origin), np.array(event.ray_direction))
        if member is None or self.shown is None:
            return
        drawing = self.shown[0]
        own = drawing["cell_data"]["member_id"] == member
        parts = []
        for field in self.fields.values():
            found = fields.values(drawing, field)[own]
            low, high = float(found.min()), float(found.max())
            if low == high == 0.0:
                continue
            text, least = fields.with_unit(high, field.unit), fields.number(low)
            parts.append(f"{field.words} {text if least == fields.number(high) else f'{least} to {text}'}")
        event.client.add_notification(self.network.members[member], "; ".join(parts), auto_close_seconds=8.0)

    # The worker: one thread does all that takes time.

    def _work(self) -> None:
        looked_at, moved_at = time.monotonic(), 0.0
        while not self.stopped:
            with self.wake:
                if not (self.dirty or self.looked or self.actions):
                    self.wake.wait(WATCH if self.curve is not None else min(WATCH, REST))
                dirty, self.dirty = self.dirty, False
                looked, self.looked = self.looked, False
                action = self.actions.popleft() if self.actions else None
                asked = self.asked - len(self.actions)
            with self.lock:
                try:
                    if dirty:
                        self._update()
                        moved_at = time.monotonic()
                    if looked:
                        self._redraw()
                    if action is not None:
                        self._do(*action)
                    if self.curve is None and not self.waiting and time.monotonic() - moved_at >= REST:
                        self._compute_curve()
                    if time.monotonic() - looked_at >= WATCH:
                        looked_at = time.monotonic()
                        self._watch()
                except Exception as error:  # The page must say it and go on.
                    self.panel.say([f"{type(error).__name__}: {error}"], "bad")
                    self.server.flush()
            with self.wake:
                self.answered = max(self.answered, asked)
                self.wake.notify_all()

    @property
    def waiting(self) -> bool:
        """Whether something newer is asked for."""
        return self.dirty or bool(self.actions)

    def _update(self) -> None:
        """Brings everything to where the sliders are."""
        values, position = self.panel.values(), float(self.panel.steps.value)
        if position != round(position) or position == 0:
            self._on_the_way(values, position)
            return
        begin = time.perf_counter()
        follow = self._follow(round(position))
        now = follow.go(values)
        self.times["solve"] = time.perf_counter() - begin
        if now.lost and follow.live is not None and self.panel.snaps.value:
            self._snap(follow, now, values)
            return
        self._numbers(now, follow)
        self._shape(follow, now)

    def _numbers(self, now: Now, follow: Follow) -> None:
        """The numbers and the verdict, at once."""
        if now.probes:
            self.panel.show_numbers(now.probes)
        self._judge(now, follow)
        self.server.flush()
        self.now = now
        chosen = now.probes.get(str(self.panel.probe.value))
        if chosen is not None and self.moved in now.values and not now.failure:
            self.visited.append((now.values[self.moved], chosen.value))
        if self.curve is not None:
            kept = {name: value for name, value in now.values.items() if name != self.moved}
            if self.curve[0] != (self.moved, self.panel.probe.value, kept, self.panel.steps.value):
                self.curve = None
            else:
                self._draw_curve()

    def _judge(self, now: Now, follow: Follow) -> None:
        """The verdict in plain words."""
        say = [words.verdict(now.stable, self.judged, self.network.dimension)] if now.probes else []
        if now.lost and follow.live is not None:
            stopped = ", ".join(
                f"{handle.label} {fields.number(now.values[handle.name], 5)}"
                for handle in self.handles
                if abs(now.values[handle.name] - self.panel.values()[handle.name]) > 0
            )
            say = [
                "Here it ends: the equilibrium, or its stability, is lost.",
                f"Shown is the last state before, at {stopped}.",
            ]
        elif now.failure:
            say = (
                [now.failure, "The last state that was reached is shown."]
                if follow.live
                else [*now.failure.splitlines()]
            )
        elif self.snapped:
            say.append(SNAPPED)
        self.panel.say(say, "bad" if now.failure or now.stable is False else "good")

    def _shape(self, follow: Follow, now: Now) -> None:
        """The shape: what is quick at once, else a carried one until nothing newer is waiting."""
        begin = time.perf_counter()
        if follow.drawing is not None and self.times.get("shape", 1.0) > QUICK:
            self._draw(follow.sketch(now), follow.unloaded)
            if self.waiting:
                return
        exact = follow.shape(now)
        self.times["shape"] = time.perf_counter() - begin
        if follow.solution is not None and follow.whole:
            self.judged = _judged_in(follow)
        self._draw(follow.drawing, follow.unloaded)
        if not exact and now.probes and not now.failure:
            self.panel.say([words.verdict(now.stable, self.judged, self.network.dimension), STAYED], "wait")

    def _draw(self, drawing: dict[str, Any] | None, unloaded: dict[str, Any] | None) -> None:
        if drawing is None or unloaded is None:
            return
        self.shown = drawing, unloaded
        values = line_values(drawing, self.panel.shown_field)
        self.scale = fields.scale_of(self.panel.shown_field, values, self.scale)
        self.picture.show(drawing, unloaded, values, self.scale)
        self.panel.show_legend(self.scale)
        self.server.flush()

    def _redraw(self) -> None:
        """Colours, names and loads as they are asked for."""
        self.picture.with_ghost, self.picture.with_names = self.panel.ghost.value, self.panel.names.value
        self.picture.with_loads = self.panel.loads.value
        if self.shown is not None:
            self._draw(*self.shown)
        self.visited.clear()
        self.curve = None

    def _on_the_way(self, values: dict[str, float], position: float) -> None:
        """A state between the ends of steps."""
        key = tuple(values.values())
        if self.way is None or self.way[0] != key:
            try:
                self.way = (key, Way(self.network.set(**values), self.accuracy))
            except Error as error:
                self.panel.say(str(error).splitlines(), "bad")
                return
        way = self.way[1]
        place = way.nearest(position)
        self.panel.show_numbers(way.probes(place))
        self.panel.say([way.label(place), way.verdict(place)])
        self._draw(way.drawing(place), way.drawing(None))

    # Snaps and modes.

    def _snap(self, follow: Follow, now: Now, values: dict[str, float]) -> None:
        """Shows where stability is lost, and plays the jump from there."""
        self._numbers(now, follow)
        self._shape(follow, now)
        before, turn = self.shown, now.turn
        why = follow.snap(values)
        if why:
            self.panel.say(
                ["Here it ends: the equilibrium, or its stability, is lost.", f"It cannot snap from here: {why}"], "bad"
            )
            self.server.flush()
            return
        after = follow.go(values)
        self.snapped = True
        if before is not None and now.displacement is not None and after.displacement is not None and turn is not None:
            # The equilibrium that is left is looked at for a moment.
            time.sleep(0.25)
            whole = after.turn @ np.swapaxes(turn, 1, 2) if after.turn is not None else turn
            vectors = rotation_vectors(whole)
            for frame in np.linspace(0.0, 1.0, round(SNAP * RATE))[1:]:
                if self.waiting:
                    break
                part = float(frame * frame * (3.0 - 2.0 * frame))
                between = (1.0 - part) * now.displacement + part * after.displacement
                self._draw(carry.carried(before[0], follow.joined, between, carry.rotations(part * vectors)), before[1])
                time.sleep(1.0 / RATE)
        self._numbers(after, follow)
        self._shape(follow, after)

    def _mode(self) -> None:
        """Plays the motion in which the present state is softest, by linear buckling about it."""
        position = max(1, round(float(self.panel.steps.value)))
        follow = self._follow(position)
        if self.shown is None or follow.drawing is None:
            return
        values = self.now.values if self.now is not None else self.panel.values()
        drawing, unloaded = self.shown
        try:
            about = follow.network.set(**values)
            found = (
                about.buckle(1, step=about.steps[-1])
                if follow.live is not None
                else about.buckle(1, along=self._broken(follow))
            )
        except Error as error:
            self.panel.say(["There is no mode to show:", *str(error).splitlines()], "bad")
            return
        if not len(found):
            self.panel.say(
                ["No factor of the loads makes it lose its stability, as far as linear buckling can say."], "good"
            )
            return
        nodes = len(self.network.nodes)
        motion, turns = found.shapes[0][:nodes, :3], found.shapes[0][:nodes, 3:]
        at = drawing["point_data"]["displacement"][:nodes]
        small = carry.carried(drawing, follow.joined, at + 1e-3 * motion, carry.rotations(1e-3 * turns))
        largest = float(
            np.linalg.norm(small["point_data"]["displacement"] - drawing["point_data"]["displacement"], axis=1).max()
        )
        if largest == 0.0 or self.picture.whole is None:
            self.panel.say(["The mode lies within a member and moves no node: it cannot be shown here."], "wait")
            return
        reach = 0.06 * self.picture.whole.size / (largest / 1e-3)
        factor = fields.number(float(found.factor[0]), 4)
        of = "all loads of this state" if follow.live is not None else "the ramp of the step"
        self.panel.say(
            [
                f"How it gives way: it would at {factor} times {of}, by linear buckling about it. The size of the motion is arbitrary."
            ],
            "wait",
        )
        for frame in np.linspace(0.0, 1.0, round(MODE * RATE)):
            if self.waiting:
                break
            part = reach * float(np.sin(4 * np.pi * frame))
            self._draw(
                carry.carried(drawing, follow.joined, at + part * motion, carry.rotations(part * turns)), unloaded
            )
            time.sleep(1.0 / RATE)
        self._draw(drawing, unloaded)
        if self.now is not None:
            self._judge(self.now, follow)

    @staticmethod
    def _broken(follow: Follow) -> str | None:
        """The step that did not reach its end."""
        if follow.solution is None:
            return None
        return next(
            (step for index, step in enumerate(follow.solution.steps) if follow.solution.fraction[index] < 1.0), None
        )

    # Curves.

    def _compute_curve(self) -> None:
        """The probe over the slider that was moved last, from the unloaded network at each place."""
        handle = next((each for each in self.handles if each.name == self.moved), None)
        follow = self.follows.get(round(float(self.panel.steps.value)))
        if handle is None or follow is None or follow.problem is None or self.now is None:
            self.curve = ((), np.zeros(0), np.zeros(0))
            return
        kept = {name: value for name, value in self.now.values.items() if name != self.moved}
        count = GRID if self.times.get("shape", 0.0) < 0.05 else GRID // 3
        grid = np.linspace(handle.low, handle.high, count)
        x = np.tile([{**self.panel.values(), **kept}[name] for name in follow.problem.parameters], (count, 1))
        x[:, follow.problem.parameters.index(self.moved)] = grid
        chosen = str(self.panel.probe.value)
        if chosen not in follow.problem.probes:
            self.curve = ((), np.zeros(0), np.zeros(0))
            return
        rows = []
        for row in x:
            if self.waiting:
                return
            rows.append(follow.problem(row)[follow.problem.probes.index(chosen)])
        self.curve = ((self.moved, chosen, kept, self.panel.steps.value), grid, np.array(rows))
        self._draw_curve()

    def _draw_curve(self) -> None:
        assert self.curve is not None and self.now is not None
        _, grid, y = self.curve
        chosen = self.now.probes.get(str(self.panel.probe.value))
        if chosen is None or self.moved not in self.now.values or not len(grid):
            return
        label = next(handle.label for handle in self.handles if handle.name == self.moved)
        here = self.now.values[self.moved], chosen.value
        error = chosen.error if np.isfinite(chosen.error) else 0.0
        self.panel.show_curve(label, chosen.unit, grid, y, list(self.visited), here, error)

    # What buttons ask for.

    def _do(self, action: str, client: viser.ClientHandle | None) -> None:
        if action == "back":
            self.panel.set_values({handle.name: handle.value for handle in self.handles})
            self.panel.steps.value = float(len(self.network.steps))
            self.snapped = False
            self._take(self.network, self.handles)
            self._ask()
        elif action == "mode":
            self._mode()
        elif client is not None:
            save.action(self, action, client)

    # The file.

    def _stamp(self) -> Any:
        if self.path is None:
            return None
        try:
            found = os.stat(self.path)
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size

    def _watch(self) -> None:
        """Reads the file again where it changed; a mistake leaves the last good network."""
        if self.path is None or (stamp := self._stamp()) == self.seen or stamp is None:
            return
        self.seen = stamp
        try:
            network = load(self.path).set(**self.settings)
            network.check()
            moved, handles = moving(network, self.ranges)
        except Error as error:
            self.panel.complain(str(error).replace(str(self.path), self.path.name))
        except OSError:
            # It is being written.
            self.seen = None
        else:
            self.picture.remove()
            self._take(moved, handles)
            self._show_network()
            self._ask()
            self.panel.complain("")
        self.server.flush()

    # From outside.

    @property
    def address(self) -> str:
        """The address of the page, with its key."""
        return self.server.address

    def stop(self) -> None:
        """Ends it."""
        self.stopped = True
        self._ask()
        self.worker.join(timeout=5.0)
        self.server.stop()

    def set(self, **values: float) -> Session:
        """Moves sliders, as a person would; `step` is the slider through the steps."""
        names = {handle.name for handle in self.handles}
        for name, value in values.items():
            if name == "step" and name not in names:
                self.panel.steps.value = float(value)
            elif name in names:
                self.panel.set_values({name: value})
                self._values_moved(name)
            else:
                raise KeyError(f"there is no slider {name!r}; there are {', '.join(sorted(names | {'step'}))}")
        self._ask()
        return self

    def settle(self, timeout: float = 30.0) -> Session:
        """Waits until everything that was asked for is shown."""
        with self.wake:
            if not self.wake.wait_for(lambda: self.answered >= self.asked or self.stopped, timeout):
                raise TimeoutError(f"not shown within {timeout} s")
        return self

    def probes(self) -> dict[str, Probe]:
        """The numbers that the page shows."""
        return dict(self.now.probes) if self.now is not None else {}

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.address}" width="100%" height="680" style="border:1px solid #8884"></iframe>'

    def __repr__(self) -> str:
        return f"<Session {self.name!r}: {'stopped' if self.stopped else self.address}>"


def _judged_in(follow: Follow) -> str:
    """Whether stability was judged in space or in the plane alone."""
    if follow.network.dimension != "plane" or follow.solution is None:
        return "space"
    return str(follow.solution.to_dict()["steps"][-1]["stability"])


def rotation_vectors(matrices: Array) -> Array:
    """(n, 3), the rotation vectors of some rotations, of norm at most π."""
    cosine = np.clip((np.trace(matrices, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)
    angle = np.arccos(cosine)
    skew = matrices - np.swapaxes(matrices, 1, 2)
    axis = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1) / 2.0
    sine = np.linalg.norm(axis, axis=1)
    return np.asarray(axis * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-9), 1.0)[:, None])
