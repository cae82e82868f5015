"""One mutated file given to its command, in this process, and what is wrong with the answer."""

from __future__ import annotations

import contextlib
import io
import os
import re
import signal
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from types import FrameType

from tests.hostile.corpus import CASES as FIRST
from tests.hostile.corpus import Case
from tests.hostile.corpus_newest import NEWEST
from tests.hostile.mutations import Mutation, mutated
from vcmm.face.cli import run

CASES = (*FIRST, *NEWEST)
LONGEST = 4096  # bytes of all messages together
SLOWEST = 10.0  # s of the processor
LOCATED = re.compile(r"[\w./-]+:\d+")


@dataclass(frozen=True)
class Answer:
    code: int
    out: str
    err: str
    seconds: float


class _Slow(BaseException):
    pass


@dataclass(frozen=True)
class Verdict:
    """Case, file and mutation; what is wrong with the answer ("" where nothing is)."""

    case: str
    file: str
    mutation: Mutation
    answer: Answer
    fault: str


def ask(command: tuple[str, ...], seconds: float = 300.0) -> Answer:
    """Run a command in this process; code -1 where it takes more seconds of the processor, or twelve times as many to wait."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise _Slow

    out, err = io.StringIO(), io.StringIO()
    clocks = (
        (signal.SIGPROF, signal.ITIMER_PROF, seconds),
        (signal.SIGALRM, signal.ITIMER_REAL, 12 * seconds),
    )
    before = [signal.signal(number, stop) for number, _, _ in clocks]
    for _, clock, limit in clocks:
        signal.setitimer(clock, limit)
    began = time.process_time()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            code = run(list(command))
    except _Slow:
        code = -1
    finally:
        for (number, clock, _), old in zip(clocks, before):
            signal.setitimer(clock, 0.0)
            signal.signal(number, old)
    return Answer(code, out.getvalue(), err.getvalue(), time.process_time() - began)


def fault(case: Case, mutation: Mutation, answer: Answer) -> str:
    """What is wrong with an answer."""
    said = answer.err.encode("utf-8", "replace")
    if answer.code == -1:
        return f"no answer in {SLOWEST:g} s"
    if answer.code == 70:
        return "exit 70: " + answer.err.strip().rsplit("\n", 2)[-2][:200]
    if answer.code not in (0, 1, 2):
        return f"exit {answer.code}"
    if len(said) > LONGEST:
        return f"{len(said)} bytes of messages"
    if answer.code == 2 and not LOCATED.search(answer.err):
        return "no file and line"
    if "\x1b" in answer.err or "\x00" in answer.err:
        return "control characters in the message"
    if answer.code != 2 and mutation.wrong and not ("remark" in answer.out or "note:" in answer.err):
        return f"accepted with exit {answer.code}"
    return ""


@contextlib.contextmanager
def inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def trial(folder: Path, seed: int) -> Verdict:
    """Mutation number `seed`: a case, one of its files, one mutation, one answer."""
    rng = Random(seed)
    case = CASES[seed % len(CASES)]
    name = rng.choice(case.mutated)
    mutation = mutated(rng, name, case.files[name], case.survey)
    case.lay_out(folder)
    (folder / name).write_bytes(mutation.content)
    with inside(folder):
        answer = ask(case.command, SLOWEST)
    return Verdict(case.name, name, mutation, answer, fault(case, mutation, answer))
