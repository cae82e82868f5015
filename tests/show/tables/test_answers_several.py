"""The answer lines of folders, machines over time, several parts, certificates, tests and loops, by hand."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vcmm.files.learned.certificate_comparison import CertifiedU
from vcmm.files.learned.fleet import Change
from vcmm.learn.calibration.acceptance import Figure
from vcmm.learn.diagnosis.trend import STEP, Trend
from vcmm.show.report.answers import answer_text
from vcmm.show.tables import answers_machine, answers_parts, answers_runs
from vcmm.show.tables.answers import answer_of
from vcmm.show.tables.calibration import U_OF_FIGURE


def record(file: str, verdict: str = "explained", problem: str = "", machine: str = "mill") -> dict[str, Any]:
    return {"file": file, "machine": machine, "verdict": verdict, "problem": problem}


def moved(name: str, by: float) -> Change:
    """From 1.0 to 1.0 + by, u 0.1 each: by / (0.1 sqrt 2) standard uncertainties."""
    when = (("a.toml", "2026-01-01"), ("b.toml", "2026-02-01"))
    went = Trend(STEP, amount=by, u=0.14, first=0, last=1)
    return Change("mill", name, "value", "um", when[0], when[1], (1.0, 0.1), (1.0 + by, 0.1), 2, 2, trend=went, recordings=when)  # fmt: skip


def test_a_folder_says_first_what_changed_most():
    records = [record("a.toml"), record("b.toml", "nothing missing"), record("c.toml", problem="no column X", machine="")]  # fmt: skip
    lines = answers_runs.folder_answers(records, [moved("squareness", 0.5), moved("backlash X", 3.0)])
    text = answer_text(lines)
    assert text.splitlines() == [
        "mill: 1 of 2 recordings (hold what the machine file lacks): changed",
        "    most: backlash X value: steps by +3.00 ± 0.14 µm between 2026-01-01 and 2026-02-01; to confirm: vcmm diagnose b.toml",
        "Not diagnosed: 1 of 3 recordings: cannot be read or diagnosed",
        "    first: c.toml: no column X",
    ]


def test_a_folder_without_a_change_says_so():
    (line,) = answers_runs.folder_answers([record("a.toml"), record("b.toml")], [])
    assert (line.verdict, line.kind) == ("no change shown", "good")
    (alone,) = answers_runs.folder_answers([record("a.toml")], [])
    assert alone.verdict == "one recording"


@dataclass
class Judged:
    """What a line asks of a result."""

    value: float
    text: str
    p: float
    name: str = "bore"
    nominal: float = 30.0
    type: str = "diameter"
    unit: str = "mm"
    budget: tuple[Any, ...] = ()
    tolerance: tuple[float, float] = (29.99, 30.01)
    u: float = 0.0005
    half_width: None = None
    bias_in_U: float = 0.0
    decision: Any = field(init=False)

    def __post_init__(self) -> None:
        self.decision = SimpleNamespace(text=self.text, p_conform=self.p)
        self.stated = (0.001, 2.0)
        self.interval = (self.value - 0.001, self.value + 0.001)
        self.p = 0.95


def test_several_parts_are_one_line_per_characteristic_with_the_worst():
    parts: Any = [
        SimpleNamespace(part=name, characteristics=[SimpleNamespace(name="bore", result=one)])
        for name, one in (
            ("1", Judged(30.0, "conforms", 1.0)),
            ("2", Judged(30.0095, "undecided", 0.84)),
            ("3", Judged(30.0105, "undecided", 0.16)),
        )
    ]
    (line,) = answers_parts.parts_answers(parts)
    assert line.name == "bore, 3 parts"
    assert line.verdict == "2 undecided, 1 conform"
    assert line.kind == "warning"
    assert line.result == "30.0105 mm ± 1.0 µm"
    assert line.coverage.endswith("the worst: part 3")
    assert line.numbers["undecided"] == 2
    sure: Any = [
        SimpleNamespace(
            part=n, characteristics=[SimpleNamespace(name="bore", result=Judged(v, "conforms", 1.0))]
        )
        for n, v in (("17", 30.001), ("18", 30.002))
    ]
    assert (
        "worst: part 18" in answers_parts.parts_answers(sure)[0].coverage
    )  # both 1.0: 8 um from the limit, the other 9
    alone = answers_parts.parts_answers(parts[:1])
    assert alone == [answer_of(parts[0].characteristics[0].result)]


def test_figures_with_a_limit_come_first_the_worst_of_them_on_top():
    figures = [
        Figure("A X", 5.0, 0.5),
        Figure("E X", 3.0, 0.5, 8.0, 0.999),
        Figure("R X", 7.0, 0.5, 8.0, 0.40),
    ]
    lines = answers_runs.acceptance_answers(figures)
    assert [(x.name, x.result, x.kind) for x in lines] == [
        ("R X", "7.0 ± 1.0 µm", "bad"),  # U = 2 u = 1.0
        ("E X", "3.0 ± 1.0 µm", "good"),
    ]
    assert lines[0].limits == "at most 8 µm"
    free = answers_runs.acceptance_answers([Figure(f"A {i}", float(i), None) for i in range(9)])
    assert [x.name for x in free] == ["A 0", "A 1", "A 2", "A 3", "A 4"]
    ways = [Figure(n, 1.0, None) for n in ("A X", "A+ X", "A- X", "R X")]
    assert [x.name for x in answers_runs.acceptance_answers(ways)] == ["A X", "R X"]


def test_a_figure_without_u_of_its_readings_has_no_digits_of_rounding():
    """u = 1.7e-15 um is rounding of nothing: no U, and the value to 0.01 um as every number without U."""
    (line,) = answers_runs.acceptance_answers([Figure("G(b) XY", 5.6573935048618145, 1.7e-15)], recorded=True)
    assert answer_text([line]).splitlines()[0] == "G(b) XY: 5.66 µm (u of the readings not in it)"
    assert [U_OF_FIGURE.terminal(u, "mm") for u in (1.7e-15, 0.12, None)] == ["–", "0.120 µm", "–"]
    (own,) = answers_runs.acceptance_answers([Figure("G(b) XY", 5.657, 0.12)], recorded=True)
    assert own.result == "5.66 ± 0.24 µm"
    (predicted,) = answers_runs.acceptance_answers([Figure("G(b) XY", 5.657, 1.7e-15)])
    assert (predicted.result, predicted.coverage) == ("5.66 µm", "")


@pytest.mark.parametrize(
    ("p", "words"),
    [(0.0004, "fails, probability to pass < 0.1 %"), (0.62, "passes, probability to pass 62 %")],
)
def test_the_verdict_of_a_test_agrees_with_its_probability(p: float, words: str):
    (line,) = answers_runs.acceptance_answers([Figure("E0", 12.6, 1.2, 4.3, p)])
    assert line.verdict.replace("\N{NO-BREAK SPACE}", " ").startswith(words[:-2])


@pytest.mark.parametrize(
    ("alarms", "verdict"),
    [
        ((), "the last is as predicted"),
        ((1,), "the last is as predicted; alarm before: bar1 (2026-02-15)"),
        ((0, 2), "the last: alarm, not as predicted; alarm before: bar0 (2026-01-15)"),
    ],
)
def test_the_state_of_a_machine_names_every_alarm(alarms: tuple[int, ...], verdict: str):
    checks = [
        SimpleNamespace(
            name=f"bar{i}",
            date=f"2026-0{i + 1}-15",
            when=30.0 * i,
            alarm=i in alarms,
            suspects=(),
            answer="",
            spread=1.0,
        )
        for i in range(3)
    ]
    followed = SimpleNamespace(tracked=SimpleNamespace(machine=SimpleNamespace(name="bridge")))
    day = SimpleNamespace(when=60.0)
    track: Any = SimpleNamespace(checks=checks, followed=followed, courses=(), dated=day, at="2026-03-15")
    assert answers_runs.track_answers(track)[0].verdict == verdict


def test_a_certificate_says_u_and_what_one_more_fact_gives():
    worth: Any = SimpleNamespace(
        by_fact=[CertifiedU("E0_MPE", "bore", "mm", 0.00190), CertifiedU("+ R0_MPL", "bore", "mm", 0.00154)],
        coverage=[SimpleNamespace(characteristic="bore", share=0.961), SimpleNamespace(characteristic="bore", share=0.93)],
    )  # fmt: skip
    (line,) = answers_parts.certificate_answers(worth, 0.94)
    assert answer_text([line]).splitlines() == [
        "bore: U = 1.90 µm (half the 95 % interval, by E0_MPE): holds 93.0\u00a0% of machines at the limit",
        "    with R0_MPL too: U = 1.54 µm",
    ]
    assert line.kind == "bad"  # 0.93 < 0.94


def test_a_part_that_departs_says_where_and_a_part_as_predicted_too():
    row = SimpleNamespace(
        name="width", unit="mm", nominal=20.0, measured=20.004, prediction=20.001, u=0.001, e_n=1.5
    )
    cut: Any = SimpleNamespace(
        comparisons=[row],
        mismatch=[SimpleNamespace(text="goes with X, line 12")],
        off=np.array([0.004, -0.006]),
        scatter=0.0005,
    )
    first, second = answers_parts.cut_answers(cut)
    assert first.result == "at most 6.00 µm from nominal"
    assert (first.verdict, first.because) == ("departs from its prediction", "goes with X, line 12")
    assert second.result == "measured +4.00 µm, predicted +1.0 ± 2.0 µm"  # from 20: 4, 1; U = 2 x 1
    assert (second.verdict, second.kind) == ("E_n = 1.50", "warning")
    cut.mismatch = []
    assert answers_parts.cut_answers(cut)[0].verdict == "as predicted"


@pytest.mark.parametrize(
    ("met", "proof_met", "refused", "verdict"),
    [
        (True, True, "", "met"),
        (False, False, "", "not met"),
        (False, True, "", "met by the cut, the real part open"),
        (False, False, "worse by 2 µm", "refused"),
    ],
)
def test_the_loop_says_first_whether_the_next_part_is_right(
    met: bool, proof_met: bool, refused: str, verdict: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(answers_machine, "diagnosis_answers", lambda d: [])
    proof = SimpleNamespace(limit=0.0015, is_met=proof_met, after=SimpleNamespace(largest=0.001, worst="top"))
    loop: Any = SimpleNamespace(
        cut=SimpleNamespace(off=np.array([0.012, -0.02])), proof=proof, refusal=refused, open_words="", setting="", is_met=met,
        program="next.nc", diagnosis=None,
    )  # fmt: skip
    (line,) = answers_machine.loop_answers(loop)
    assert line.verdict == verdict
    assert "this part 20.00 µm (2 measured points)" in line.result
    assert line.limits == "at most 1.50 µm"


def test_machines_compared_name_the_best_and_the_next():
    found = {
        "a.toml": {"refused": "", "value": 2.0, "words": ("as it lies", "2.0 µm")},
        "b.toml": {"refused": "", "value": 3.0, "words": ("turned", "3.0 µm")},
        "c.toml": {"refused": "too small"},
    }
    (line,) = answers_parts.machine_answers(["a.toml", "b.toml"], found)
    assert answer_text([line]).splitlines() == [
        "Machine a.toml: 2.0 µm (as it lies): best of 3 machines",
        "    next: b.toml: 3.0 µm; 1 cannot take the part",
    ]


def _fault(
    members: tuple[tuple[str, float], ...], probability: float, family: float, rivals: tuple[str, ...]
) -> Any:
    kin = SimpleNamespace(members=tuple(SimpleNamespace(effect=n, probability=p) for n, p in members))
    size = SimpleNamespace(value=-1.31, u=0.015, unit="um")
    return SimpleNamespace(
        effect="backlash", where={"axis": "Y"}, parameters={"gap": size}, share=0.9, probability=probability, family="play", family_probability=family,
        kin=kin, cannot_be_told_from=rivals, with_rivals=family,
    )  # fmt: skip


def test_a_certain_family_stands_first_and_what_is_open_behind_it():
    """A play of 0.975 of which 0.17 is a backlash had begun with "probability 16.8 %"."""
    open_shape = _fault((("backlash", 0.17), ("lost_motion", 0.81)), 0.17, 0.975, ("lost_motion",))
    line = answers_machine._fault_line(1, open_shape)  # type: ignore[arg-type]
    assert line.name == "1. play Y, written as backlash Y"
    assert (
        line.verdict.replace("\xa0", " ")
        == "probability 97.5 %; open is its shape: lost motion 81.0 %, backlash 17.0 %"
    )
    assert (line.kind, line.limits) == ("good", "")
    # a rival of another family stays a rival
    foreign = _fault((("backlash", 0.3), ("lost_motion", 0.3)), 0.3, 0.6, ("lost_motion", "servo_lag[X]"))
    assert (
        answers_machine._fault_line(1, foreign).limits.replace("\xa0", " ")
        == "or servo lag[X], 60.0 % together"
    )  # type: ignore[arg-type]
    # one shape alone says its own probability
    alone = _fault((("backlash", 0.96),), 0.96, 0.96, ())
    assert answers_machine._fault_line(1, alone).verdict.replace("\xa0", " ") == "probability 96.0 %"  # type: ignore[arg-type]
