"""Pointed directions and the index of axes: exact chains, large offsets taken out before anything is linearised."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.job import diagnose
from vcmm.task.response.indexing import index_text, move_readings, settle_index
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.pointing import pointing_observations, with_down
from vcmm.task.response.recording import Recording

DEG, URAD = np.pi / 180.0, 1e-6
HALF = 0.5 * np.sqrt(3.0)
NODES = {"C": Axis("C", (-np.pi, np.pi)), "B": Axis("B", (-np.pi, np.pi))}
MOUNT = Machine("mount", "cmm", parse_structure("w b C B t"), NODES)


def turn(about: int, angle: np.ndarray | float, v: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) turned about x, y or z, written out; no code of the package."""
    c, s, out = np.cos(angle), np.sin(angle), np.array(v, dtype=float)
    j, k = (about + 1) % 3, (about + 2) % 3
    out[:, j], out[:, k] = c * v[:, j] - s * v[:, k], s * v[:, j] + c * v[:, k]
    return out


def sightings(n: int = 60, noise: float = 0.0, **wrong: float) -> Recording:
    """A mount that points along x at zero: readings and the true directions, exact.

    c, b: index of the axes; tilt: base about x; sag: towards -z in proportion to its lateral share; cross: tool about z.
    """
    rng = np.random.default_rng(3)
    c, b = rng.uniform(-2.5, 2.5, n), rng.uniform(-1.4, 0.2, n)
    tool = turn(2, wrong.get("cross", 0.0), np.tile([1.0, 0.0, 0.0], (n, 1)))
    p = turn(2, c + wrong.get("c", 0.0), turn(1, b + wrong.get("b", 0.0), tool))
    p = turn(0, wrong.get("tilt", 0.0), p)
    p = p - wrong.get("sag", 0.0) * (np.array([0.0, 0.0, 1.0]) - p[:, 2:] * p)
    p = p + noise * rng.standard_normal((n, 3))
    p = p / np.linalg.norm(p, axis=1)[:, None]
    columns = {f"pointed_{a}": p[:, i] for i, a in enumerate("xyz")}
    run = Run({"C": c, "B": b}, np.tile([500.0, 0.0, 0.0], (n, 1)), columns)
    value, direction = pointing_observations(run, MOUNT, 1.0)
    none = np.full(2 * n, -1, dtype=np.intp)
    row = np.repeat(np.arange(n), 2)
    return Recording("m", "angle", run, value, False, row, direction, none, noise=Normal(max(noise, 1e-9)))


def test_an_observation_is_the_turn_from_where_the_tool_should_point():
    # B = 0, C = 0: tool along x; observed 30 deg towards y: +30 deg about x cross B = x cross y = z, none about B = y
    run = Run({"C": np.zeros(1), "B": np.zeros(1)}, np.array([[100.0, 0.0, 0.0]]))
    seen = {"pointed_x": np.array([HALF]), "pointed_y": np.array([0.5]), "pointed_z": np.zeros(1)}
    run = run.with_columns(seen)
    value, direction = pointing_observations(run, MOUNT, 1.0)
    assert direction == pytest.approx(np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), abs=1e-15)
    assert value == pytest.approx([0.0, 30 * DEG], abs=1e-15)
    assert pointing_observations(run, MOUNT, -1.0)[0] == pytest.approx(-value, abs=1e-15)
    back = run.with_columns({"pointed_x": np.array([-1.0]), "pointed_y": np.zeros(1)})
    with pytest.raises(ModelLimit, match="180 deg off"):
        pointing_observations(back, MOUNT, 1.0)


def test_an_index_of_degrees_is_taken_out_exactly():
    # 5.3 and -2.1 deg; first order would leave (5.3 deg)^2 / 2 = 4 mrad
    recording = replace(sightings(c=5.3 * DEG, b=-2.1 * DEG), nuisance={"index": ""})
    found = settle_index(recording, MOUNT)
    assert found.index["C"] == pytest.approx(5.3 * DEG, abs=1e-8)
    assert found.index["B"] == pytest.approx(-2.1 * DEG, abs=1e-8)
    assert np.abs(found.value).max() < 1e-8
    assert "C 5.3 deg" in index_text(found)
    once = recording.value - _fitted(recording)
    assert np.abs(once).max() > 1e-3  # what one linear step leaves


def _fitted(recording: Recording) -> np.ndarray:
    columns, _ = nuisance_columns(recording, MOUNT)
    return columns @ np.linalg.lstsq(columns, recording.value, rcond=None)[0]


def test_an_index_of_its_own_for_every_setup():
    recording = sightings(c=1.0 * DEG)
    labels = {"setup": np.array(["a", "b"] * 30)}
    q = recording.run.q("C") - np.where(
        labels["setup"] == "b", 2.0 * DEG, 0.0
    )  # b reads 2 deg less: index 3 deg
    run = replace(recording.run, position={**recording.run.position, "C": q}, labels=labels)
    value, direction = pointing_observations(run, MOUNT, 1.0)
    recording = replace(recording, run=run, value=value, direction=direction, nuisance={"index": "setup"})
    found = settle_index(recording, MOUNT)
    assert found.index["C[setup=a]"] == pytest.approx(1.0 * DEG, abs=1e-8)
    assert found.index["C[setup=b]"] == pytest.approx(3.0 * DEG, abs=1e-8)


def test_the_index_of_a_path_moves_the_nominal_tip():
    # table C turned by 10 deg more than read: tip (100, 0, 0) seen from the table; -> exact chord, no first order
    chain = parse_structure("w C' b X t")
    axes = {"C": Axis("C", (-np.pi, np.pi)), "X": Axis("X", (0.0, 200.0))}
    table = Machine("t", "machine-tool", chain, axes)
    c = np.linspace(-1.0, 1.0, 7)
    run = Run({"C": c, "X": np.full(7, 100.0)}, np.zeros((7, 3)))
    # a primed axis turns the table by -q, so the tip goes by +q in its axes: (100 cos q, 100 sin q)
    at = lambda q: np.stack([100 * np.cos(q), 100 * np.sin(q), 0 * q], axis=1)  # noqa: E731
    gap = at(c + 10 * DEG) - at(c)
    row, direction = np.repeat(np.arange(7), 3), np.tile(np.eye(3), (7, 1))
    none = np.full(21, -1, dtype=np.intp)
    recording = Recording("p", "path", run, gap.ravel(), False, row, direction, none, nuisance={"index": ""})
    found = settle_index(recording, table)
    assert found.index["C"] == pytest.approx(10 * DEG, abs=1e-8)
    assert found.index["X"] == pytest.approx(0.0, abs=1e-6)
    assert np.abs(found.value).max() < 1e-6
    with pytest.raises(UsageError, match="tip_x_mm"):
        settle_index(replace(recording, run=table.prepare(run)), table)


def test_an_angle_about_one_axis_only_cannot_be_moved_far():
    recording = sightings(c=5.0 * DEG)
    bare = replace(recording.run, columns={})
    recording = replace(recording, run=bare, nuisance={"index": ""})
    with pytest.raises(ModelLimit, match="pointed_x"):
        settle_index(recording, MOUNT)
    small = replace(sightings(c=2e-4), nuisance={"index": ""})
    small = replace(small, run=replace(small.run, columns={}))
    assert settle_index(small, MOUNT).index["C"] == pytest.approx(2e-4, abs=1e-6)


def test_moving_there_and_back_changes_nothing():
    recording = replace(sightings(c=0.02), nuisance={"index": ""})
    again = move_readings(move_readings(recording, MOUNT, {"C": 0.3}), MOUNT, {"C": -0.3})
    assert again.value == pytest.approx(recording.value, abs=1e-14)


def test_offset_of_an_angle_is_how_the_tool_stands():
    recording = replace(sightings(cross=1e-4), nuisance={"offset": ""})
    columns, names = nuisance_columns(recording, MOUNT)
    assert names == ("offset.turn_y", "offset.turn_z")  # a turn about the tool itself is not seen
    fit = np.linalg.lstsq(columns, recording.value, rcond=None)[0]
    assert fit == pytest.approx([0.0, 1e-4], abs=1e-8)


def test_gravity_in_the_frame_of_the_tool():
    run = Run({"C": np.array([0.4]), "B": np.array([-0.5 * np.pi])}, np.array([[100.0, 0.0, 0.0]]))
    seen = with_down(run, MOUNT, np.array([0.0, 0.0, -2.0]))
    # the tool stands upright (B = -90 deg turns x to +z): gravity runs back along it
    assert [seen.columns[f"down_{c}"][0] for c in "xyz"] == pytest.approx([-1.0, 0.0, 0.0], abs=1e-15)
    with pytest.raises(UsageError, match="down is no direction"):
        with_down(run, MOUNT, np.zeros(3))


@pytest.mark.thorough
def test_base_and_sag_of_a_mount_are_named_behind_degrees_of_index():
    made = sightings(120, 10 * URAD, c=5.0 * DEG, b=1.5 * DEG, cross=3e-3, tilt=1e-3, sag=200 * URAD)
    made = replace(made, nuisance={"index": "", "offset": ""})
    run = with_down(settle_index(made, MOUNT).run, MOUNT, np.array([0.0, 0.0, -1.0]))
    found = diagnose(replace(settle_index(made, MOUNT), run=run), MOUNT, seed=1)
    answer = {(a.effect, *a.where.values()): a.parameters for a in found.answer}
    assert answer["rotary_location", "A0C"]["tilt"].value == pytest.approx(1000.0, abs=20.0)
    assert answer["gravity_flexure",]["angle"].value == pytest.approx(200.0, abs=20.0)
    assert any("index" in w and "C 5" in w for w in found.warnings)


def test_a_file_of_pointed_directions(tmp_path):
    made = sightings(20, c=5.0 * DEG)
    (tmp_path / "machine.toml").write_text(
        'vcmm = "machine/1"\nstructure = "w b C B t"\n[axes.C]\ntravel = ["-180 deg", "180 deg"]\n'
        '[axes.B]\ntravel = ["-180 deg", "180 deg"]\n'
    )
    head = "C_deg,B_deg,offset_x_mm,offset_y_mm,offset_z_mm,pointed_x,pointed_y,pointed_z"
    table = np.column_stack(
        [
            made.run.q("C") / DEG,
            made.run.q("B") / DEG,
            made.run.offset,
            made.run.vector("pointed_x", "pointed_y", "pointed_z"),
        ]
    )
    rows = [",".join(f"{v:.12f}" for v in row) for row in table]
    (tmp_path / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    words = (
        'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "{}"\nobserved = "actual - commanded"\n'
        'history = "none"\ndown = [0, 0, -1]\n[nuisance]\nindex = ""\n[noise]\nu = "10 urad"\n'
    )
    (tmp_path / "recording.toml").write_text(words.format("angle"))
    recording, _ = load_recording(tmp_path / "recording.toml")
    assert recording.m == 40
    assert recording.index["C"] == pytest.approx(5.0 * DEG, abs=1e-8)
    assert "down_x" in recording.run.columns
    (tmp_path / "recording.toml").write_text(words.format("path").replace("urad", "um"))
    with pytest.raises(DataError, match='write kind = "angle"'):
        load_recording(tmp_path / "recording.toml")
    (tmp_path / "recording.toml").write_text(words.format("angle"))
    (tmp_path / "data.csv").write_text("\n".join([head, rows[0].rsplit(",", 1)[0] + ",2.0"]) + "\n")
    with pytest.raises(DataError, match="unit vector"):
        load_recording(tmp_path / "recording.toml")
