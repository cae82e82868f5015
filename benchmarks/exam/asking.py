"""The two ways to put a recording to `vcmm diagnose`: the command's entry point called in this process, and a fresh process.

Both are given the same words and both are read by the JSON document that the command prints, nothing else. The first saves
the start of Python and the import of heavy libraries (about a second of five); a test holds the two equal.
"""

from __future__ import annotations

import contextlib
import io
import json
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

LIMIT = 900.0  # s
START = "import sys; from vcmm.face.cli import main; sys.exit(main())"


class OutOfTime(BaseException):
    """Not an Exception, so that the command does not take it for a fault of its own."""


def diagnose(
    recording: Path, seed: int, out: Path | None = None, limit: float = LIMIT, fresh: bool = False
) -> tuple[dict[str, Any], float]:
    """The printed document and the seconds it took. Raises RuntimeError with the command's words when it refuses."""
    words = ["diagnose", str(recording), "--seed", str(seed), "--json"] + (["--out", str(out)] if out else [])
    start = time.perf_counter()
    code, told, said = (_elsewhere if fresh else _here)(words, limit)
    if code not in (0, 1):
        raise RuntimeError(f"exit {code}: {said.strip()[-600:]}")
    return json.loads(told), time.perf_counter() - start


def _elsewhere(words: Sequence[str], limit: float) -> tuple[int, str, str]:
    command = [sys.executable, "-c", START, *words]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"no answer within {limit:g} s") from None
    return done.returncode, done.stdout, done.stderr


def _here(words: Sequence[str], limit: float) -> tuple[int, str, str]:
    from vcmm.face.cli import run

    told, said = io.StringIO(), io.StringIO()
    try:
        with _stopped_after(limit), contextlib.redirect_stdout(told), contextlib.redirect_stderr(said):
            code = run(list(words))
    except OutOfTime:
        raise RuntimeError(f"no answer within {limit:g} s") from None
    return code, told.getvalue(), said.getvalue()


@contextlib.contextmanager
def _stopped_after(limit: float) -> Iterator[None]:
    """Raises OutOfTime in the block after `limit` seconds; without effect outside a main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(_signal: int, _frame: FrameType | None) -> None:
        raise OutOfTime

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
