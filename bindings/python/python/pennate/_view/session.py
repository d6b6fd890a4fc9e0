"""What happens: sliders move, the state follows, pictures and numbers with it; the file is read again when it changes."""

from __future__ import annotations

import collections
import math
import pathlib
import threading
import time
from collections.abc import Iterable, Mapping, Sequence

import viser

from .. import _arguments
from .._errors import Error
from .._look import words
from .._network import Network
from . import films, handles, save, verdicts
from .curve import Curve
from .display import Display, described, named
from .follow import Follow, Now, Probe
from .handles import Handle, moving
from .panel import Panel
from .server import LOOPBACK, Server
from .source import Source
from .way import Way

# Seconds between two looks at the file, and of rest before a curve is drawn.
WATCH, REST = 0.25, 0.25
# Shapes that take longer are shown as carried ones first, and solved for when nothing has moved for a while, in seconds.
QUICK, STILL = 0.015, 0.12
# Sending is done by another thread: without a rest the picture would hold it up, in seconds.
SENDING = 0.002
# While values come faster than pictures are made, pictures are at most so far apart, in seconds.
APART = 0.1
# For so long the equilibrium that is left is looked at before it snaps, in seconds.
LEAVING = 0.25

# The last port that there is.
PORTS = 65535


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
        ranges = handles.limits(ranges or {})
        if _arguments.whole(port, "port") > PORTS:
            raise ValueError(f"port: a number up to {PORTS} expected, not {port}")
        self.source, self.accuracy = Source(path, settings or {}, ranges), _arguments.accuracy(accuracy)
        self.lock, self.wake = threading.RLock(), threading.Condition()
        self.stopped, self.dirty, self.looked, self.moved = False, True, False, ""
        # What is asked for is counted, and what is answered.
        self.asked, self.answered = 1, 0
        self.actions: collections.deque[tuple[str, viser.ClientHandle | None]] = collections.deque()
        self.times: dict[str, float] = {}
        self.drawn_at = 0.0
        shown, found = moving(network, ranges)
        handles.check_names(ranges, found)
        self._take(shown, found)
        self.server = Server(port, self.name, bind, hosts)
        self.panel = Panel(self.server, self.name)
        self.panel.on_values, self.panel.on_step = self._values_moved, self._ask
        self.panel.on_look, self.panel.on_action = self._look, self._act
        self.curve = Curve(self.panel)
        self._show_network()
        self.server.scene.on_click()(lambda event: self.display.clicked(event))
        self.worker = threading.Thread(target=self._work, name="pennate view", daemon=True)
        self.worker.start()

    # The network.

    @property
    def name(self) -> str:
        """What the page is called."""
        return named(self.network)

    def _take(self, network: Network, handles: list[Handle]) -> None:
        self.network, self.handles = network, handles
        self.follows: dict[int, Follow] = {}
        self.way: tuple[tuple[float, ...], Way] | None = None
        self.now: Now | None = None
        # The probes that the page shows.
        self.numbers: dict[str, Probe] = {}
        self.judged = "space"
        self.snapped = False

    def _show_network(self) -> None:
        self.panel.title(self.name, described(self.network))
        self.panel.set_handles(self.handles, self.network.steps)
        self.panel.set_probes(tuple(self.network.probes))
        joined = self._follow(len(self.network.steps)).joined
        self.display = Display(self.server, self.panel, self.network, joined)
        self.curve.forget()
        self.moved = self.handles[0].name if self.handles else ""

    def _follow(self, step: int) -> Follow:
        """What follows the state at the end of a step, which is counted from one."""
        if step not in self.follows:
            names = tuple(handle.name for handle in self.handles)
            self.follows[step] = Follow(self.network, names, step - 1, self.accuracy)
        return self.follows[step]

    @property
    def _handle(self) -> Handle | None:
        """The slider that was moved last."""
        return next((each for each in self.handles if each.name == self.moved), None)

    # What a person does.

    def _values_moved(self, name: str) -> None:
        if name != self.moved:
            self.moved = name
            self.curve.forget()
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

    # The worker: one thread does all that takes time.

    def _work(self) -> None:
        looked_at, moved_at = time.monotonic(), 0.0
        while not self.stopped:
            with self.wake:
                if not (self.dirty or self.looked or self.actions):
                    self.wake.wait(WATCH)
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
                        self.display.redraw()
                        self.curve.forget()
                    if action is not None:
                        self._do(*action)
                    if not self.waiting and time.monotonic() - moved_at >= REST:
                        self.display.name()
                        if self.curve.due:
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
        if not (self.waiting and time.monotonic() - self.drawn_at < APART):
            self._shape(follow, now)

    def _numbers(self, now: Now, follow: Follow) -> None:
        """The numbers and the verdict, at once."""
        if now.probes:
            self._show_numbers(now.probes)
        self._judge(now, follow)
        self.server.flush()
        time.sleep(SENDING)
        self.now = now
        self.curve.visit(now, self._handle)

    def _show_numbers(self, probes: dict[str, Probe]) -> None:
        self.numbers = dict(probes)
        self.panel.show_numbers(probes)

    def _judge(self, now: Now, follow: Follow) -> None:
        """The verdict in plain words."""
        asked = self.panel.values()
        say = verdicts.of_state(now, follow, self.judged, asked, self.handles, self.snapped)
        self.panel.say(say, "bad" if now.failure or now.stable is False else "good")

    def _shape(self, follow: Follow, now: Now) -> None:
        """The shape: what is quick at once, else a carried one until nothing newer has come for a while."""
        if follow.drawing is not None and self.times.get("shape", 1.0) > QUICK:
            self.display.draw(follow.sketch(now), follow.unloaded)
            self.drawn_at = time.monotonic()
            with self.wake:
                if self.wake.wait_for(lambda: self.waiting or self.stopped, STILL):
                    return
        begin = time.perf_counter()
        exact = follow.shape(now, lambda: self.waiting or self.stopped)
        if exact is None:
            return
        self.times["shape"] = time.perf_counter() - begin
        if follow.solution is not None and follow.whole:
            self.judged = verdicts.judged_in(follow)
        self.display.draw(follow.drawing, follow.unloaded)
        self.drawn_at = time.monotonic()
        if not exact and now.probes and not now.failure:
            verdict = words.verdict(now.stable, self.judged, self.network.dimension)
            self.panel.say([verdict, verdicts.STAYED], "wait")

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
        self._show_numbers(way.probes(place))
        self.panel.say([way.label(place), way.verdict(place)])
        self.display.draw(way.drawing(place), way.drawing(None))

    # Snaps, modes and curves.

    def _snap(self, follow: Follow, now: Now, values: dict[str, float]) -> None:
        """Shows where stability is lost, and plays the jump from there."""
        self._numbers(now, follow)
        self._shape(follow, now)
        before = self.display.shown
        why = follow.snap(values)
        if why:
            self.panel.say([verdicts.LOST, f"It cannot snap from here: {why}"], "bad")
            self.server.flush()
            return
        after = follow.go(values)
        self.snapped = True
        if before is not None:
            time.sleep(LEAVING)
            self._play(films.snap(before[0], follow, now, after), before[1])
        self._numbers(after, follow)
        self._shape(follow, after)

    def _mode(self) -> None:
        """Plays the motion in which the present state is softest."""
        follow = self._follow(max(1, round(float(self.panel.steps.value))))
        if self.display.shown is None or follow.drawing is None:
            return
        drawing, unloaded = self.display.shown
        try:
            mode = films.softest(follow, self.now.values if self.now is not None else self.panel.values())
            self.panel.say([mode.words()], "wait")
            self._play(mode.frames(drawing, follow, self.display.picture.size), unloaded)
        except films.NothingToShow as why:
            self.panel.say(why.sentences, why.kind)
            return
        self.display.draw(drawing, unloaded)
        if self.now is not None:
            self._judge(self.now, follow)

    def _play(self, frames: Iterable[films.Drawing], unloaded: films.Drawing) -> None:
        """Shows drawings one after the other, until something newer is asked for."""
        for frame in frames:
            if self.waiting:
                return
            self.display.draw(frame, unloaded)
            time.sleep(1.0 / films.RATE)

    def _compute_curve(self) -> None:
        follow = self.follows.get(round(float(self.panel.steps.value)))
        self.curve.compute(follow, self.now, self._handle, self.times.get("shape", 0.0), lambda: self.waiting)

    # What buttons ask for, and the file.

    def _do(self, action: str, client: viser.ClientHandle | None) -> None:
        if action == "back":
            self.panel.set_values({handle.name: handle.value for handle in self.handles})
            self.panel.steps.value = float(len(self.network.steps))
            self._take(self.network, self.handles)
            self.curve.forget()
            self._ask()
        elif action == "mode":
            self._mode()
        elif client is not None:
            save.action(self, action, client)

    def _watch(self) -> None:
        """Reads the file again where it changed; a mistake leaves the last good network."""
        found = self.source.again()
        if found is None:
            return
        if isinstance(found, str):
            self.panel.complain(found)
        else:
            # Asked for first: whoever waits until all is shown waits for this network.
            self._ask()
            self.display.picture.remove()
            self._take(*found)
            self._show_network()
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
            if name not in names | {"step"}:
                raise KeyError(f"there is no slider {name!r}; there are {', '.join(sorted(names | {'step'}))}")
            if not math.isfinite(_arguments.real(value, name)):
                raise ValueError(f"{name}: a finite number expected, not {value}")
        for name, value in values.items():
            if name in names:
                self.panel.set_values({name: value})
                self._values_moved(name)
            else:
                self.panel.steps.value = float(value)
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
        return dict(self.numbers)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    def _repr_html_(self) -> str:
        return f'<iframe src="{self.address}" width="100%" height="680" style="border:1px solid #8884"></iframe>'

    def __repr__(self) -> str:
        return f"<Session {self.name!r}: {'stopped' if self.stopped else self.address}>"
