"""A room that changes in time and place: by pencil, and through a scenario."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.core.errors import DataError
from vcmm.core.run import Run
from vcmm.files.own.scenario import load_scenario
from vcmm.physics.structure.room import RoomDrift, RoomDriftOfScale, RoomGradient
from vcmm.task.measuring.settings import Settings

RATE = 1.0 / 3600.0  # 1 K/h in K/s


def run_at(point: tuple[float, float, float], time: float, x: float = 0.0) -> Run:
    columns = {f"part_{c}_mm": np.array([v]) for c, v in zip("xyz", point)}
    return Run({"X": np.array([x])}, np.zeros((1, 3)), columns | {"time_s": np.array([time])})


def test_a_part_grows_with_the_room() -> None:
    """400 mm of steel, 1 K/h for 30 min: 11.5e-6 x 0.5 K x 400 mm = 2.3 um, away from the origin, indicated larger."""
    six = RoomDrift(rate=RATE, alpha=11.5e-6).error_motion(run_at((0.0, 400.0, 0.0), 1800.0))
    assert np.allclose(six, [[0, 2.3e-3, 0, 0, 0, 0]])


def test_an_uncorrected_scale_grows_with_the_room() -> None:
    """500 mm of a scale of 8 um/(m K), 0.5 K: 2 um too far."""
    six = RoomDriftOfScale("X", rate=RATE, alpha=8e-6).error_motion(run_at((0.0, 0.0, 0.0), 1800.0, 500.0))
    assert np.allclose(six, [[2e-3, 0, 0, 0, 0, 0]])


def test_a_part_in_a_gradient_grows_and_bows() -> None:
    """alpha 1e-5, 0.5 K/m along z, at (100, 0, 200) mm: s = 200, p^2 = 50 000.

    x: 5e-9 x 200 x 100 = 0.1 um; z: 5e-9 x (200 x 200 - 25 000) = 0.075 um. On a beam along x, at (1000, 0, 0): z = -2.5 um, the sag.
    """
    effect = RoomGradient("z", g=5e-4, alpha=1e-5)
    assert np.allclose(effect.error_motion(run_at((100.0, 0.0, 200.0), 0.0)), [[1e-4, 0, 0.75e-4, 0, 0, 0]])
    assert np.allclose(effect.error_motion(run_at((1000.0, 0.0, 0.0), 0.0)), [[0, 0, -2.5e-3, 0, 0, 0]])


def test_strains_of_a_gradient_are_alike_in_all_directions_and_without_shear() -> None:
    """Differences over 0.1 mm about (30, -20, 50): du_i/dx_j + du_j/dx_i = 2 alpha g z where i = j, else 0."""
    effect, at, h = RoomGradient("z", g=5e-4, alpha=1e-5), np.array([30.0, -20.0, 50.0]), 0.1

    def moved(p: np.ndarray) -> np.ndarray:
        return effect.error_motion(run_at(tuple(p), 0.0))[0, :3]  # type: ignore[arg-type]

    slopes = np.array([(moved(at + h * e) - moved(at - h * e)) / (2 * h) for e in np.eye(3)])
    assert np.allclose(slopes + slopes.T, 2 * 1e-5 * 5e-4 * 50.0 * np.eye(3), atol=1e-15)


def budget(path: Path) -> tuple[dict[str, float], float, object]:
    scenario = load_scenario(path)
    task = scenario.task()
    found = evaluate(task, Settings(trials=2000, certify=20))
    c = next(c for c in found.characteristics if c.name == "bore to front")
    return {b.input: b.u for b in c.budget}, c.u, task


@pytest.mark.thorough
def test_each_change_of_the_room_has_its_line(tmp_path: Path) -> None:
    """front lies 40 mm from the bore, in which the part's origin is, and is touched last, at t after the start: at a rate r it moves
    outwards by alpha r 40 mm t. The 16 points of the bore grow by alpha r y_i t_i along y while they are touched, so that its centre
    moves by the mean of 2 y_i alpha r t_i (least squares of radial departures 15 mm alpha r t_i on two levels, evenly spaced).

    K t = 40 mm t + mean(2 y_i t_i):   u(hour) = 11.5e-6 K t 6 K/h / sqrt 3,   u(day) = 11.5e-6 K t pi 48 K / 24 h / sqrt 2
    """
    stated = 'room_hour = "6 K/h"\nroom_day = "48 K/d"\nroom_gradient = "3 K/m"\n[job]\n'
    lines, u, task = budget(edited(tmp_path, ("[job]\n", stated)))
    bare, u_bare, _ = budget(edited(tmp_path, name="bare.toml"))
    touches = task.touches  # type: ignore[attr-defined]
    hours, rows = touches.run.column("time_s") / 3600.0, touches.rows
    bore = float((2.0 * touches.points[rows["bore"], 1] * hours[rows["bore"]]).mean())
    length = 11.5e-6 * (40.0 * float(hours[rows["front"]].mean()) + bore)
    assert lines["environment.room_hour"] == pytest.approx(length * 6.0 / math.sqrt(3.0), rel=0.02)
    assert lines["environment.room_day"] == pytest.approx(length * math.pi * 2.0 / math.sqrt(2.0), rel=0.02)
    assert {f"room_gradient[{d}].g" for d in "xyz"} <= set(lines)
    assert not any("room" in name for name in bare)
    added = sum(x**2 for name, x in lines.items() if "room_" in name)
    assert u**2 - u_bare**2 == pytest.approx(added, rel=0.02)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ('room_hour = "0.5 K/d"', "a change in K per h"),
        ('room_day = "0.5 K"', "a change in K per d"),
        ('room_gradient = "-1 K/m"', "not negative"),
        ('room_hour = "0.5 um/h"', "temperature rate"),
    ],
)
def test_what_is_no_change_of_a_room_is_refused(tmp_path: Path, line: str, says: str) -> None:
    with pytest.raises(DataError, match=says):
        load_scenario(edited(tmp_path, ("[job]\n", f"{line}\n[job]\n")))


def test_a_part_without_expansion_does_not_follow_a_room(tmp_path: Path) -> None:
    edits = (
        ("[job]\n", 'room_hour = "1 K/h"\n[job]\n'),
        ('expansion = "11.5 um/(m K)"\nu_expansion = "1 um/(m K)"\n', ""),
    )
    with pytest.raises(DataError, match="acts through the expansion of the part"):
        load_scenario(edited(tmp_path, *edits))
