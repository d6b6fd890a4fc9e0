"""The controls and the numbers beside the picture."""

from __future__ import annotations

import html
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import viser
import viser.uplot

from .._look.fields import Array, Field, Scale, number, ticks, with_error
from .follow import Probe
from .handles import Handle

STYLE = (
    "<style>.pn{font-size:13px;line-height:1.45;padding:0 .9em 0 .5em}.pn-faint{color:#868e96}.pn table{border-collapse:collapse;width:100%;"
    "font-variant-numeric:tabular-nums}.pn td{padding:1px 0;border-bottom:1px solid #8884}.pn td:last-child"
    "{text-align:right;white-space:nowrap}.pn-say{border-left:4px solid #0b7a3b;background:#8881;padding:.35em .6em;"
    "margin:.2em 0}.pn-bad{border-color:#a3132d}.pn-wait{border-color:#be730d}.pn pre{white-space:pre;overflow-x:auto;"
    "font-size:11px;margin:0}.pn-bar{height:10px;border-radius:2px}.pn-marks{display:flex;justify-content:space-between;"
    "font-size:11px}</style>"
)


class Panel:
    """Everything that is not the picture; `ask` is called with what a person does."""

    def __init__(self, server: viser.ViserServer, title: str) -> None:
        self.server, self.gui = server, server.gui
        self._fields: Mapping[str, Field] = {}
        self.on_values: Callable[[str], None] = lambda name: None
        self.on_step: Callable[[], None] = lambda: None
        self.on_look: Callable[[], None] = lambda: None
        self.on_action: Callable[[str, viser.ClientHandle | None], None] = lambda action, client: None
        gui = self.gui
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        gui.main_panel.dock_right()
        self.head = gui.add_html("")
        self.mistake = gui.add_html("", visible=False)
        self.verdict = gui.add_html("")
        self.numbers = gui.add_html("")
        self.places = gui.add_html("")
        self.sliders: dict[str, Any] = {}
        self.folder: Any = None
        self.steps: Any = None
        self.order = gui.add_folder("Values", expand_by_default=True)
        self.actions: dict[str, Any] = {}
        self._rest()
        self.title(title)

    def _rest(self) -> None:
        gui = self.gui
        with gui.add_folder("Curve"):
            self.probe = gui.add_dropdown("Probe", ("–",))
            empty = np.zeros(2)
            self.plot = gui.add_uplot(
                (np.array([0.0, 1.0]), empty, empty),
                ({}, {"label": "from unloaded", "stroke": "#245f97", "width": 2}, {}),
                height=200,
                padding=(10, 16, 0, 0),
            )
        with gui.add_folder("Look"):
            self.field: Any = gui.add_dropdown("Colour", ("–",))
            self.legend = gui.add_html("")
            self.ghost = gui.add_checkbox("Unloaded shape", True)
            self.names: Any = gui.add_checkbox("Names", True)
            self.loads = gui.add_checkbox("Loads", True)
        with gui.add_folder("Stability"):
            self.snaps = gui.add_checkbox("Snap where stability is lost", True)
            self.actions["mode"] = gui.add_button("Show how it gives way")
        with gui.add_folder("Save", expand_by_default=False):
            for action, label in (
                ("picture", "Picture"),
                ("film", "GIF of the way"),
                ("network", "Network file with these values"),
                ("results", "Results"),
                ("report", "Report"),
            ):
                self.actions[action] = gui.add_button(label)
        for action, button in self.actions.items():
            button.on_click(self._asks(action))
        self.probe.on_update(lambda event: self.on_look() if event.client_id is not None else None)
        for control in (self.field, self.ghost, self.names, self.loads):
            control.on_update(lambda event: self.on_look() if event.client_id is not None else None)

    def _asks(self, action: str) -> Callable[[Any], None]:
        return lambda event: self.on_action(action, event.client)

    def title(self, text: str, below: str = "") -> None:
        """What the page is called, and what stands at the top."""
        self.gui.set_panel_label(text)
        self.head.content = f'{STYLE}<div class="pn pn-faint">{html.escape(below)}</div>'

    def set_handles(self, handles: Sequence[Handle], steps: Sequence[str]) -> None:
        """Sliders for everything that moves, and one through the steps."""
        if self.folder is not None:
            self.folder.remove()
        self.sliders = {}
        with self.order:
            self.folder = self.gui.add_folder(None)
            with self.folder:
                for handle in handles:
                    slider = self.gui.add_slider(
                        handle.label, handle.low, handle.high, handle.step, float(handle.value)
                    )
                    slider.on_update(self._moved(handle.name))
                    self.sliders[handle.name] = slider
                marks = tuple((float(index), str(index)) for index in range(len(steps) + 1))
                hint = "0 is unloaded; " + ", ".join(
                    f"{index + 1} is the end of ‘{name}’" for index, name in enumerate(steps)
                )
                self.steps = self.gui.add_slider(
                    "step", 0.0, float(len(steps)), 0.02, float(len(steps)), marks=marks, hint=hint
                )
                self.steps.on_update(lambda event: self.on_step() if event.client_id is not None else None)
                back = self.gui.add_button("Back to the values of the file")
                back.on_click(self._asks("back"))

    def _moved(self, name: str) -> Callable[[Any], None]:
        return lambda event: self.on_values(name) if event.client_id is not None else None

    def values(self) -> dict[str, float]:
        """Where the sliders are."""
        return {name: float(slider.value) for name, slider in self.sliders.items()}

    def set_values(self, values: Mapping[str, float]) -> None:
        """Puts sliders somewhere."""
        for name, value in values.items():
            if name in self.sliders:
                self.sliders[name].value = value

    def show_numbers(self, probes: Mapping[str, Probe]) -> None:
        """The probes with their errors."""
        rows = "".join(
            f'<tr><td>{html.escape(name)}</td><td data-probe="{html.escape(name)}" data-value="{probe.value!r}">'
            f"{with_error(probe.value, probe.error, html.escape(probe.unit))}</td></tr>"
            for name, probe in probes.items()
        )
        self.numbers.content = (
            f'<div class="pn"><table>{rows or "<tr><td>The file has no probes.</td></tr>"}</table></div>'
        )

    def say(self, sentences: Sequence[str], kind: str = "good") -> None:
        """The verdict and what belongs to it; `kind` is `"good"`, `"bad"` or `"wait"`."""
        marked = {"good": "", "bad": " pn-bad", "wait": " pn-wait"}[kind]
        text = "<br>".join(html.escape(each) for each in sentences if each)
        self.verdict.content = f'<div class="pn"><div class="pn-say{marked}">{text}</div></div>'

    def complain(self, text: str) -> None:
        """What is wrong with the file, as the program prints it; nothing takes it away."""
        if text:
            note = "The last network that was good stays." if text else ""
            self.mistake.content = (
                f'<div class="pn"><div class="pn-say pn-bad"><pre>{html.escape(text)}</pre>{note}</div></div>'
            )
        if self.mistake.visible != bool(text):
            self.mistake.visible = bool(text)

    def show_legend(self, scale: Scale) -> None:
        """What the colours mean."""
        text = f'<div class="pn"><div>{html.escape(scale.words())}</div>'
        if not scale.uniform:
            marks = "".join(f"<span>{number(mark)}</span>" for mark in scale.marks)
            gradient = ",".join(scale.stops())
            text += f'<div class="pn-bar" style="background:linear-gradient(90deg,{gradient})"></div>'
            text += f'<div class="pn-marks">{marks}</div>'
        if self.legend.content != text + "</div>":
            self.legend.content = text + "</div>"

    def show_places(self, text: str) -> None:
        """Where what has a name is, for the page to find what the pointer is on."""
        content = f'<div hidden data-pn-places="{html.escape(text)}"></div>'
        if self.places.content != content:
            self.places.content = content

    def set_probes(self, names: Sequence[str]) -> None:
        """Which probes have curves."""
        wanted = tuple(names) or ("–",)
        if tuple(self.probe.options) != wanted:
            self.probe.options = wanted

    @property
    def fields(self) -> Mapping[str, Field]:
        """What can be shown."""
        return self._fields

    @fields.setter
    def fields(self, fields: Mapping[str, Field]) -> None:
        self._fields = fields
        wanted = tuple(field.words for field in fields.values())
        if tuple(self.field.options) != wanted:
            self.field.options = wanted

    @property
    def shown_field(self) -> Field:
        """What the colours are to show."""
        return next(field for field in self._fields.values() if field.words == self.field.value)

    def show_curve(
        self,
        label: str,
        unit: str,
        grid: Array,
        y: Array,
        visited: list[tuple[float, float]],
        here: tuple[float, float],
        error: float,
    ) -> None:
        """A probe against a slider: from the unloaded network for each place, and as it was moved through."""
        x = np.unique(np.concatenate([grid, [place for place, _ in visited], [here[0]]]))
        curve, dots, now = (np.full(len(x), math.nan) for _ in range(3))
        curve[np.searchsorted(x, grid)] = y
        for place, value in visited:
            dots[np.searchsorted(x, place)] = value
        now[np.searchsorted(x, here[0])] = here[1]
        name = f"{self.probe.value}, {unit}" if unit else str(self.probe.value)
        series: tuple[Any, ...] = (
            {"label": label},
            {"label": name, "stroke": "#245f97", "width": 2, "points": {"show": False}},
            {"label": "moved through", "stroke": "#be730d", "width": 0, "points": {"show": True, "size": 4}},
            {"label": "now", "stroke": "#a3132d", "width": 0, "points": {"show": True, "size": 10, "fill": "#a3132d"}},
        )
        known = np.concatenate([curve, dots, now])
        known = known[np.isfinite(known)]
        # What differs by less than its error is one value.
        middle, spread = float(known.mean()), max(20.0 * error, 1e-6 * float(np.abs(known).max()))
        marks = ticks(min(float(known.min()), middle - spread), max(float(known.max()), middle + spread))
        low, high = (marks[0], marks[-1]) if len(marks) > 1 else (marks[0] - 1.0, marks[0] + 1.0)
        scales: Any = {"x": {"time": False, "range": (float(x[0]), float(x[-1]))}, "y": {"range": (low, high)}}
        axes: Any = ({"label": label, "size": 44}, {"size": 58})
        with self.server.atomic():
            self.plot.series = series
            self.plot.scales = scales
            self.plot.axes = axes
            self.plot.data = (x, curve, dots, now)
