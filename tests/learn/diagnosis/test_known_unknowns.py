"""What the maker of a recording found without a name is told in the verdict."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from vcmm.learn.diagnosis.job import describe_unknown
from vcmm.learn.diagnosis.result import Diagnosis, Fit


def diagnosis() -> Diagnosis:
    return Diagnosis(
        "nothing missing", (), None, (), None, 1.0, (), Fit(1.0, 1.0, 1.0, ()), {}, (), (), (), 0.0, 0
    )


def test_a_wave_is_told_with_its_size_and_what_to_measure_next():
    """Columns of 3 um rms: the wave is 3 um rms, the verdict is no longer that nothing is missing; ten waves of 25 s are watched."""
    known = (("tool_radius[1].dr", np.ones((4, 1))), ("unknown wave of 25 s", np.full((4, 6), 3e-3)))
    told = describe_unknown(diagnosis(), SimpleNamespace(known=known))
    assert told.verdict == "unexplained"
    assert told.unknown is not None
    assert (told.unknown.covariates, round(told.unknown.rms * 1e3, 9)) == (("time",), 3.0)
    assert "wave of 25 s" in told.reasons[0]
    assert "250 s" in told.next_measurement[0].do


def test_nothing_is_added_where_nothing_was_found():
    one = diagnosis()
    assert describe_unknown(one, SimpleNamespace(known=(("scatter.value", np.ones((4, 2))),))) is one
