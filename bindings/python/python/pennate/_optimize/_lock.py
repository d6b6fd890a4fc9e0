"""One search at a time in a directory."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from ._reader import StudyError

# Locked from the first byte behind this place on where locks are those of bytes: who holds the lock stays readable.
FAR = 1 << 20

_held: weakref.WeakSet[IO[str]] = weakref.WeakSet()


@contextlib.contextmanager
def locked(directory: Path) -> Iterator[None]:
    """Keeps others out of a directory.

    The lock is the operating system's and ends with the process, however that ends; the file `study.lock` stays, and says who had
    it last.

    Raises:
        StudyError: Another search is at work there.
    """
    directory.mkdir(parents=True, exist_ok=True)
    path = directory / "study.lock"
    with path.open("a+", encoding="utf-8") as file:
        if not _lock(file):
            file.seek(0)
            who = file.read(200).strip() or "another process"
            help = "wait until it has ended, or give another directory with -o"
            raise StudyError(f"error: another search is at work in {directory}: {who}\nhelp: {help}")
        _held.add(file)
        file.truncate(0)
        file.write(f"process {os.getpid()} on {socket.gethostname()}\n")
        file.flush()
        try:
            yield
        finally:
            _held.discard(file)


def _lock(file: IO[str]) -> bool:
    """Takes the lock of a file, which closing it gives back; returns whether nobody else has it."""
    try:
        if sys.platform == "win32":
            import msvcrt

            file.seek(FAR)
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    except OSError:
        # A file system without locks: two searches cannot be kept apart there.
        return True
    return True


def _forked() -> None:
    """A worker that was forked would keep the lock when the search has died."""
    for file in list(_held):
        file.close()
    _held.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)
