"""A certificate is an upper bound: a worse one never gives a shorter interval, a smaller U or a better decision."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import pytest

from tests.certified.task import CHARACTERISTICS, scenario_with
from vcmm.evaluation.indication import at_indication
from vcmm.evaluation.result import CharacteristicResult
from vcmm.evaluation.uncertainty import evaluate
from vcmm.files.scenario import load_scenario
from vcmm.gps.decision import CONFORMS, REJECTED
from vcmm.measuring.settings import Settings

QUICK = Settings(trials=3000, certify=5)
BETTER: Mapping[str, str] = {"E0_MPE": "1.8 um + L/350", "R0_MPL": "0.4 um", "P_Form_Sph_1x25": "0.9 um"}
WORSE = (
    {"R0_MPL": "1.5 um"},
    {"R0_MPL": "3 um"},
    {"P_Form_Sph_1x25": "1.8 um"},
    {"P_Form_Sph_1x25": "4 um"},
    {"E0_MPE": "3.6 um + L/175"},
)
SCATTER = 0.1  # of the length: ends of belts of 6000 parts scatter by so much from draw to draw
READINGS = (0.5e-3, 2e-3, 3.6e-3, 6e-3)  # mm beyond nominal; for an angle as many urad

Results = Mapping[str, CharacteristicResult]


@pytest.fixture(scope="module")
def known(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Mapping[str, str]], Results]:
    folder, kept = tmp_path_factory.mktemp("limits"), dict[str, Results]()

    def results(changes: Mapping[str, str]) -> Results:
        key = str(changes)
        if key not in kept:
            task = load_scenario(scenario_with(folder, {**BETTER, **changes})).task()
            kept[key] = {c.name: c for c in evaluate(task, QUICK, read=False).characteristics}
        return kept[key]

    return results


@pytest.mark.parametrize("name", CHARACTERISTICS)
@pytest.mark.parametrize("change", WORSE, ids=lambda c: " ".join(f"{k} {v}" for k, v in c.items()))
def test_a_worse_limit_is_never_better(
    known: Callable[[Mapping[str, str]], Results], change: Mapping[str, str], name: str
) -> None:
    good, bad = known({})[name], known(change)[name]
    assert bad.u >= good.u * (1 - SCATTER)
    for y in READINGS:
        y = y * (1e-3 if good.unit == "rad" else 1.0) + good.nominal
        better, worse = (at_indication(r, y, "probability 95 %") for r in (good, bad))
        room = SCATTER * (worse.interval[1] - worse.interval[0])
        assert worse.interval[0] <= better.interval[0] + room
        assert worse.interval[1] >= better.interval[1] - room
        for word in (CONFORMS, REJECTED):
            assert worse.decision is not None
            assert better.decision is not None
            if worse.decision.text == word and worse.coverage_shown and better.coverage_shown:
                assert better.decision.text == word


def test_a_limit_takes_nothing_off_a_reading(known: Callable[[Mapping[str, str]], Results]) -> None:
    """A perfect machine keeps every limit: the reading itself may be the true value, or more where points miss some of it."""
    for name in ("roundness", "flatness", "cylindricity", "perpendicularity", "position", "circular_runout"):
        for change in ({}, {"P_Form_Sph_1x25": "4 um"}, {"R0_MPL": "3 um"}):
            for y in READINGS:
                low, high = at_indication(known(change)[name], y, "probability 95 %").interval
                assert low <= y * 1.001, (name, y)
                assert high >= y * 0.999, (name, y)
