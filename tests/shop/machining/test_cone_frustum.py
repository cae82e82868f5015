"""The inclined cone that comes with vcmm: flank milled with five axes, and what a table beside its place makes of it."""

from __future__ import annotations

import importlib.util
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vcmm
from vcmm.files.own.library import folder
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points

UM = 1e-3


def generator():
    path = Path(__file__).resolve().parents[3] / "tools" / "cone_frustum.py"
    spec = importlib.util.spec_from_file_location("cone_frustum", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def with_effects(tmp_path, *effects):
    """(values of the characteristics, departures of all points (n,) mm) of the piece on its machine with these effects alone."""
    if not (tmp_path / "cone_frustum").exists():
        shutil.copy(folder() / "cone_frustum.toml", tmp_path)
        shutil.copytree(folder() / "cone_frustum", tmp_path / "cone_frustum")
    scenario = vcmm.load_cut(tmp_path / "cone_frustum.toml")
    kept = tuple(e for e in scenario.machine.effects if e.about.belongs_to in ("tool", "setup"))
    machine = replace(scenario.machine, effects=(*kept, *effects), inputs=())
    inputs = tuple(i for i in scenario.inputs if any(e.name == i.effect for e in machine.effects))
    task, world, _ = finished_part(set_up(replace(scenario, machine=machine, inputs=inputs)))
    points = measured_points(task, world.errors())
    beside = ((points - task.touches.points) * task.touches.normals).sum(axis=1)
    return evaluate_all(task, fit_features(task, points)), beside


def test_the_program_is_that_of_its_generator():
    shipped = (folder() / "cone_frustum" / "part.nc").read_text()
    assert shipped == generator().program()


@pytest.mark.thorough
def test_a_perfect_machine_leaves_the_chords_of_the_program(tmp_path):
    """720 blocks: the tip runs on chords of its circle of 55 mm, 55 (1 - cos 0.25 deg) = 0.52 um at most; the angles run on chords too."""
    _, beside = with_effects(tmp_path)
    assert np.abs(beside).max() < 0.6 * UM
    assert beside.max() < 0.01 * UM  # chords lie inside
    assert np.ptp(beside) > 0.1 * UM


@pytest.mark.thorough
def test_a_table_beside_its_place_changes_the_size_not_the_form(tmp_path):
    """C stands 8 um off in X. The zero turns with the part, so the tool is off by d - R(C) d: a shift of 8 um, and 8 um towards where
    the tool stands. C follows the azimuth of the tool axis; that is the azimuth of the surface only where the cone stands upright,
    so of 8 um its mean share along the radius counts, 0.86 for a lean of 10 deg, twice in the diameter. The shift itself moves the
    leaning cone through the plane of the circle: 2 x 8 um tan 15 deg sin 10 deg.
    """
    made = generator()
    azimuth = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    axes = np.array([made.tool(a)[1] for a in azimuth])
    inward = axes[:, :2] / np.linalg.norm(axes[:, :2], axis=1)[:, None]
    # a shift e moves the surface in the plane of the circle by (N . e) / (N . radial), N the normal of the cone
    slope = np.tan(made.HALF)
    along = np.array([made.turned((np.cos(a), np.sin(a), slope)) for a in azimuth])[:, :2]
    share = -float((inward * along).sum(axis=1).mean())
    plain, _ = with_effects(tmp_path)
    moved, _ = with_effects(tmp_path, RotaryLocation("X0C", offset=8 * UM))
    change = (moved - plain) / UM  # roundness lower, upper, diameter, position
    assert change[2] == pytest.approx(-16.0 * (share - slope * np.sin(made.LEAN)), abs=0.02)
    assert abs(change[0]) < 2.5  # what the share varies by, seen as form
