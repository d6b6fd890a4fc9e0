"""What is wrong is said as the program says it, and nothing ends the interpreter."""

from __future__ import annotations

import pathlib
import pickle
import subprocess
import sys

import numpy as np
import pytest

import pennate
from conftest import DYAD
from pennate import _core


def test_every_error_of_a_file_has_its_place() -> None:
    text = DYAD.replace('muscle = "silicone"', 'muscle = "silicon"')
    with pytest.raises(pennate.NetworkError) as caught:
        pennate.loads(text, name="dyad.toml")
    first, second = caught.value.errors
    assert (first.file, first.line, first.column, first.name) == ("dyad.toml", 27, 39, "silicon")
    assert first.message == "member 'left' refers to muscle 'silicon', which is not defined"
    assert first.help == "did you mean 'silicone'? known muscles: 'silicone', 'silicone_soft', 'latex'"
    assert second.line == 28
    assert str(caught.value).startswith(f"error: {first.message}\n  --> dyad.toml:27:39\n")
    assert "^^^^^^^^^ no such muscle" in str(caught.value)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.errors == caught.value.errors


def test_an_unknown_muscle_is_told_with_those_of_the_library() -> None:
    text = DYAD[: DYAD.index("[muscles.silicone]")] + DYAD[DYAD.index("[members]") :]
    with pytest.raises(pennate.NetworkError, match="known muscles: 'silicone', 'silicone_soft', 'latex'"):
        pennate.loads(text.replace('"silicone"', '"silicon"'))
    assert pennate.loads(text).solve().status == "converged"


def test_help_names_all_commands() -> None:
    def run(*arguments: str) -> tuple[int, str]:
        done = subprocess.run([sys.executable, "-W", "error", "-m", "pennate", *arguments], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    for arguments in (["--help"], ["-h"], ["help"], []):
        text = run(*arguments)[1]
        for command in ("solve", "help", "optimize", "plot", "view", "report"):
            assert text.count(f"\n  {command} ") == 1, text
    for command in ("optimize", "plot", "view", "report"):
        assert run("help", command) == run(command, "--help")
    status, text = run("polt")
    assert status == 2 and "'plot'" in text


def test_the_program_prints_the_same(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "dyad.toml"
    file.write_text(DYAD.replace('"silicone"', '"silicon"'))
    printed = subprocess.run([sys.executable, "-m", "pennate", "check", str(file)], capture_output=True, text=True)
    with pytest.raises(pennate.NetworkError) as caught:
        pennate.load(file)
    assert printed.returncode == 2
    assert printed.stderr.strip() == str(caught.value).strip()


@pytest.mark.parametrize(
    ("parameters", "error", "message"),
    [
        ({"bet": 30}, pennate.NetworkError, "there is no parameter 'bet' to set"),
        ({"beta": "thirty"}, pennate.NetworkError, "neither a number nor a quantity"),
        ({"beta": float("nan")}, ValueError, "parameter 'beta': a finite number expected"),
        ({"beta": [30]}, TypeError, "parameter 'beta': a number or a text expected"),
        ({"beta": "= sqrt(-1)"}, pennate.NetworkError, "beta"),
        ({"L": 0}, pennate.NetworkError, "at one place"),
    ],
)
def test_parameters_are_checked(parameters: dict[str, object], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        pennate.loads(DYAD, **parameters).solve().raise_for_status()  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [[], "text", None, {"nodes": {"A": object()}}, {"nodes": {"A": [np.nan, 0]}}])
def test_what_is_no_network_is_refused(wrong: object) -> None:
    with pytest.raises((TypeError, ValueError)):
        pennate.Network(wrong)  # type: ignore[arg-type]


def test_a_number_that_is_none_is_told_with_its_place() -> None:
    for value in (float("nan"), np.array([0.0, np.inf])):
        with pytest.raises(ValueError, match=r"nodes\.A\[1\]: a finite number expected"):
            pennate.Network({"nodes": {"A": [0, value] if np.ndim(value) == 0 else value, "B": (1, 2)}})


def test_a_file_that_is_not_there_is_an_error() -> None:
    with pytest.raises(pennate.NetworkError, match="cannot be read"):
        pennate.load("nowhere.toml")


def test_a_panic_is_an_exception(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(pennate.InternalError, match=r"oh dear \(bindings/python/src/guard.rs:\d+\)"):
        _core.fail("oh dear")
    assert capfd.readouterr() == ("", "")


def test_nothing_is_printed_unless_asked(snap: pennate.Network, capfd: pytest.CaptureFixture[str]) -> None:
    snap.solve()
    assert capfd.readouterr() == ("", "")


def test_what_is_remarkable_is_logged(snap: pennate.Network, caplog: pytest.LogCaptureFixture) -> None:
    snap.solve()
    assert "ends at a bifurcation" in caplog.text


def test_the_version_is_that_of_the_crate() -> None:
    manifest = pathlib.Path(__file__).parents[3] / "Cargo.toml"
    if not manifest.exists():
        pytest.skip("without the repository around it")
    assert f'version = "{pennate.__version__}"' in manifest.read_text()
