"""Departures, shifts and corrected points: micrometres from millimetres."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from vcmm.compensation.points import CorrectedPoints
from vcmm.compensation.result import Departure
from vcmm.show.tables import compensation
from vcmm.show.tables.table import in_terminal

DEPARTURE = Departure(largest=0.01234, rms=0.005, line=17)


def test_departures_and_shifts():
    one = SimpleNamespace(name="p.nc", machine="mill", shifts={"G54": np.array([1e-3, -2.5e-3, 0.0])})
    table = compensation.departures(one, [("as programmed", DEPARTURE)])
    assert table.title == "p.nc on mill: departure of the cut path from the programmed one"
    assert in_terminal(table).rows == [["as programmed", "12.34 µm", "5.00 µm", "17"]]
    assert in_terminal(compensation.shifts(one)).rows == [["G54", "+1.0 µm", "-2.5 µm", "+0.0 µm"]]
    assert compensation.departure_json(DEPARTURE) == {"max_um": 12.34, "rms_um": 5.0, "line": 17}
    assert compensation.shifts_json(one) == {"G54": [1e-3, -2.5e-3, 0.0]}


def test_what_is_not_corrected_stands_apart():
    result = SimpleNamespace(before=DEPARTURE, offset_only=DEPARTURE, after=DEPARTURE, whole=None)
    assert len(compensation.before_and_after(result)) == 3
    result.whole = (DEPARTURE, DEPARTURE)
    assert [n for n, _ in compensation.before_and_after(result)][3:] == [
        "as programmed, with reversal and lag",
        "compensated, with reversal and lag",
    ]


def test_corrected_points():
    error = np.array([[1e-3, 0.0, -2e-3]])
    indicated = np.array([[1.0, 2.0, 3.0]])
    head, row = compensation.points_csv(CorrectedPoints(indicated, error, indicated - error)).splitlines()
    assert (
        head
        == "corrected_x_mm,corrected_y_mm,corrected_z_mm,indicated_x_mm,indicated_y_mm,indicated_z_mm,ex_um,ey_um,ez_um"
    )
    assert row == "0.999000,2.000000,3.002000,1.000000,2.000000,3.000000,1.0000,0.0000,-2.0000"
