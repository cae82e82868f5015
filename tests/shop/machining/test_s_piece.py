"""The S-shaped flank that comes with vcmm: what a perfect machine leaves of a twisted surface, by its own geometry."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import vcmm
from vcmm.files.own.library import folder
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up
from vcmm.task.measuring.task import measured_points

UM = 1e-3


@cache
def generator():
    path = Path(__file__).resolve().parents[3] / "tools" / "s_piece.py"
    spec = importlib.util.spec_from_file_location("s_piece", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache
def scenario():
    return vcmm.load_cut(folder() / "s_piece.toml")


def departures(*effects):
    """(3, 24) mm along the normals, by height and ruling, of the piece on its machine with these effects alone."""
    kept = tuple(e for e in scenario().machine.effects if e.about.belongs_to in ("tool", "setup"))
    machine = replace(scenario().machine, effects=(*kept, *effects), inputs=())
    inputs = tuple(i for i in scenario().inputs if any(e.name == i.effect for e in machine.effects))
    task, world, _ = finished_part(set_up(replace(scenario(), machine=machine, inputs=inputs)))
    points = measured_points(task, world.errors())
    return ((points - task.touches.points) * task.touches.normals).sum(axis=1).reshape(3, 24)


@cache
def perfect():
    return departures()


def test_program_mesh_and_points_are_those_of_the_generator():
    made = generator()
    assert (folder() / "s_piece" / "part.nc").read_text() == made.program()
    assert (folder() / "s_piece" / "points.csv").read_text() == made.points()
    assert (folder() / "s_piece" / "flank.obj").read_text() == made.mesh()


@pytest.mark.thorough
def test_a_cylinder_cuts_a_twisted_flank_too_deep_where_it_does_not_touch():
    """R (1 - cos a), a the angle between the normals there and in the middle of the ruling; chords of 960 blocks add 0.1 um."""
    made = generator()
    along = [0.02 + 0.96 * k / 23 for k in range(24)]
    for row, v in enumerate((0.2, 0.5, 0.8)):
        twist = [np.clip(np.dot(made.normal(t, v), made.normal(t, 0.5)), -1.0, 1.0) for t in along]
        expected = -made.RADIUS * (1.0 - np.array(twist))
        assert perfect()[row] == pytest.approx(expected, abs=0.35 * UM)
    assert np.abs(perfect()).max() < 1.6 * UM
    assert np.abs(perfect()[[0, 2]]).max() > 0.3 * UM


@pytest.mark.thorough
def test_a_table_beside_its_place_shifts_the_flank_as_far_as_the_table_turns():
    """X0C = 8 um: the zero turns with the part, so the tool is off by d - R(C) d in the part, |d - R d| = 2 d sin(C / 2) at most."""
    moved = departures(RotaryLocation("X0C", offset=8 * UM)) - perfect()
    program = set_up(scenario()).program
    largest = max(abs(m.rotary_end[2]) for m in program.moves)
    assert np.abs(moved).max() < 2.0 * 8 * UM * np.sin(min(largest, np.pi) / 2.0) + 0.05 * UM
    assert np.abs(moved).max() > 1.0 * UM
    assert moved[0] == pytest.approx(moved[2], abs=1.0 * UM)  # the whole ruling goes along
