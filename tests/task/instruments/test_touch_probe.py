"""Touches to a recording, and the frame of the probe: numbers by pencil."""

import numpy as np
import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.task.instruments.probe_frame import normals_in_probe, with_probe_frame
from vcmm.task.instruments.touch_probe import TOUCH_PROBE, touches
from vcmm.task.instruments.touched_surfaces import TouchedSurface, recording_of_touches
from vcmm.task.response.recording import Recording

CHAIN = parse_structure("w C' b Y X Z t")
TABLE = Machine(
    "table",
    "machine-tool",
    CHAIN,
    {a: Axis(a, (-9.0, 9.0) if a == "C" else (-500.0, 500.0)) for a in CHAIN.letters},
)
SIDES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1.0]])


def run_of(tips, turn=0.0):
    tips = np.asarray(tips, dtype=float)
    q = {a: tips[:, i] for i, a in enumerate("XYZ")} | {"C": np.full(len(tips), turn)}
    return Run(q, np.zeros((len(tips), 3)), {}, {"feature": np.array(["1"] * len(tips))})


def recorded(tips, surface, turn=0.0):
    run = run_of(tips, turn)
    return recording_of_touches(TABLE, run, {"1": surface}, 3.0, np.arange(1, run.n + 1))


def test_a_sphere_that_is_larger_reads_further_out():
    # R + r = 12 + 3 = 15 mm; stopped at 15.002 mm on every side: +2 um beside; the only touch along Z is where the middle is
    # found, 2 um higher, which is its place: radius +2 um and place -2 um say the same
    read = recorded(15.002 * SIDES, TouchedSurface("sphere", (0, 0, 0), radius=12.0))
    assert read.direction == pytest.approx(SIDES, abs=0.002 / 15 * 1.01)
    assert read.value == pytest.approx([0.002] * 4 + [0.0], abs=2e-6)
    assert read.nuisance == {"offset": "feature", "radius": ""}


def test_a_touch_beside_the_middle_is_no_error_of_the_surface():
    # the sphere stands 0.2 mm further along X than said: touches along Y meet it at sqrt(15^2 - 0.2^2) = 14.998667 mm,
    # 1.33 um lower than a touch through the middle; its middle is found, and nothing is left
    y = np.sqrt(15.0**2 - 0.2**2)
    tips = [[15.2, 0, 0], [-14.8, 0, 0], [0, y, 0], [0, -y, 0], [0, 0, y]]
    read = recorded(tips, TouchedSurface("sphere", (0, 0, 0), radius=12.0))
    assert np.abs(read.value).max() < 1e-9
    assert read.direction[2] == pytest.approx([-0.2 / 15, y / 15, 0], abs=1e-9)


def test_a_table_that_stands_elsewhere_is_read_along_the_normals():
    # at C = 0 and at C = 180 deg the sphere is found 10 um further along X of the machine: of the table that is +10 um once
    # and -10 um then, about its mean
    there = np.array([100.0, 0, 0]) + [0.01, 0, 0]
    back = np.array([-100.0, 0, 0]) + [0.01, 0, 0]
    tips = np.concatenate([there + 15 * SIDES, back + 15 * SIDES])
    run = run_of(tips)
    run = Run(run.position | {"C": np.repeat([0.0, np.pi], 5)}, run.offset, {}, run.labels)
    read = recording_of_touches(
        TABLE, run, {"1": TouchedSurface("sphere", (100, 0, 0), radius=12.0)}, 3.0, np.arange(10)
    )
    along = (read.value * read.direction[:, 0])[np.abs(read.direction[:, 0]) > 0.5]
    assert along == pytest.approx([0.01, 0.01, -0.01, -0.01], abs=1e-9)
    assert set(read.run.labels["pose"]) == {"1", "2"}


def test_a_ring_and_a_face():
    # ring of 20 mm radius, ball 3 mm: the middle stops at 17 mm; at 17.003 mm the surface is read 3 um inside the material: -3 um
    ring = recorded(17.003 * SIDES[:4], TouchedSurface("ring", (0, 0, 0), radius=20.0))
    assert ring.value == pytest.approx(-0.003, abs=1e-9)
    assert ring.direction == pytest.approx(-SIDES[:4], abs=1e-9)
    # a face x = 50 that looks to +X: ball of 3 mm stops at 53; at 53.004: +4 um
    face = recorded([[53.004, 7, 8]], TouchedSurface("plane", (50, 0, 0), (1, 0, 0)))
    assert face.value == pytest.approx(0.004, abs=1e-9)


def test_the_frame_of_the_probe_turns_with_the_spindle_and_not_with_the_table():
    run = run_of([[0, 0, 0]], turn=np.pi / 2)
    # the table has turned by -90 deg (a primed axis): a normal +Y of the table points to +X of the machine
    run = run.with_columns({"nx": np.zeros(1), "ny": np.ones(1), "nz": np.zeros(1)})
    still = with_probe_frame(run, TABLE)
    none = np.array([-1])
    one = Recording("one", "probe", still, np.zeros(1), True, np.array([0]), np.array([[0, 1.0, 0]]), none)
    assert normals_in_probe(one, still)[0] == pytest.approx([1, 0, 0], abs=1e-12)
    turned = with_probe_frame(run.with_columns({"spindle_angle_rad": np.array([np.pi / 2])}), TABLE)
    assert normals_in_probe(one, turned)[0] == pytest.approx([0, -1, 0], abs=1e-12)
    # own errors: -n for the offset; cos 2t, sin 2t, cos 3t, sin 3t at t = -90 deg: -1, 0, 0, 1; nothing along the stylus
    assert TOUCH_PROBE.error("offset").column(one, turned)[0] == pytest.approx([0, 1, 0], abs=1e-12)
    assert TOUCH_PROBE.error("lobing").column(one, turned)[0] == pytest.approx([-1, 0, 0, 1], abs=1e-12)
    assert TOUCH_PROBE.error("axial").column(one, turned)[0] == pytest.approx([0], abs=1e-12)


def test_touches_where_the_stem_is_are_left_out():
    tilted = parse_structure("w A' b Y X Z t")
    machine = Machine(
        "a",
        "machine-tool",
        tilted,
        {a: Axis(a, (-9.0, 9.0) if a == "A" else (-900.0, 900.0)) for a in tilted.letters},
    )
    # A = 90 deg: Z of the table lies along a Y of the machine; from that side all is free, from the other one is the stem
    read = touches(machine, [(0, 0, 100)], 15.0, [{"A": np.pi / 2}], SIDES, 1e-3)
    assert read.m == 4
    assert read.direction[:, 2].min() > -0.51
