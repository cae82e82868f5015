"""300 seeded mutations over all readers, in this process: no bug, no silence, one short message with file and line."""

from __future__ import annotations

import pytest

from tests.hostile.judge import CASES, Answer, ask, fault, inside, trial
from tests.hostile.mutations import Mutation

SLICES, TOGETHER = 6, 300


@pytest.mark.thorough
@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_the_files_are_right_before_they_are_mutated(case, tmp_path):
    case.lay_out(tmp_path)
    with inside(tmp_path):
        answer = ask(case.command)  # kernels may have to be compiled
    assert answer.code in (0, 1), answer.err  # 1: the plan of set-ups does not identify everything


@pytest.mark.thorough
@pytest.mark.parametrize("part", range(SLICES))
def test_mutations(part, tmp_path):
    found = [trial(tmp_path, seed) for seed in range(part, TOGETHER, SLICES)]
    wrong = [f"{v.case}, {v.file}: {v.mutation.what}: {v.fault}" for v in found if v.fault]
    assert not wrong
    assert sum(v.answer.code == 2 for v in found) > len(found) / 2  # most are noticed at all


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (Answer(70, "", "Traceback\nKeyError: 'a'\nvcmm: this is our bug\n", 0.1), "exit 70: KeyError"),
        (Answer(-1, "", "", 10.0), "no answer"),
        (Answer(2, "", "vcmm: wrong\n", 0.1), "no file and line"),
        (Answer(2, "", "vcmm: a.toml:3: " + "x" * 5000, 0.1), "bytes of messages"),
        (Answer(2, "", "vcmm: a.toml:3: \x1b[2J", 0.1), "control characters"),
        (Answer(0, "no problems found", "", 0.1), "accepted with exit 0"),
        (Answer(137, "", "", 0.1), "exit 137"),
        (Answer(2, "", "vcmm: a.toml:3: wrong", 0.1), ""),
    ],
)
def test_the_judge(answer, words):
    said = fault(CASES[0], Mutation(b"", "", True), answer)
    assert words in said if words else said == ""
