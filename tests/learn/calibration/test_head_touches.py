"""A head that turns: touches along X, Y and Z of the machine, planned, written for four controls, and read from logs of both kinds.

Own kinematics, matrices alone (ISO 841 and the convention of docs/conventions.md), machine w C' b X Y Z B t, ball at o from the gauge line, B about c:

    ball in the machine     l + c + L_B Ry(b) (o - c)          l: X Y Z of the axes; L_B = exp([A0B B0B C0B] x)
    sphere in the machine   L_C Rz(-g) p                       table C turned by -g, p its place on the table
"""

from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.own.instruments import load_certificate
from vcmm.files.own.recording import load_recording
from vcmm.files.own.touch_plan import load_touch_plan, probing_job
from vcmm.learn.calibration.job import calibrate
from vcmm.program.probing_program import CONTROLS, PlannedTouch

MACHINE = """vcmm = "machine/1"
name = "head and table"
kind = "machine-tool"
structure = "w C' b X Y Z B t"
axes.X = { travel = ["-600 mm", "600 mm"] }
axes.Y = { travel = ["-400 mm", "400 mm"] }
axes.Z = { travel = ["-200 mm", "800 mm"] }
axes.B = { travel = ["-95 deg", "95 deg"], centre = ["0 mm", "0 mm", "200 mm"] }
axes.C = { travel = ["-360 deg", "360 deg"], centre = ["0 mm", "0 mm", "0 mm"] }
repeatability = { law = "normal", u = "0.3 um" }
"""
PLAN = """vcmm = "design/1"
machine = "machine.toml"
[[setups]]
name = "spheres"
instrument = "touch probe"
u = "0.3 um"
minutes = 80
own = { offset = "1 um", lobing = "0.1 um", axial = "0.1 um" }
spheres = ["150 0 80 mm", "-80 120 140 mm", "-60 -130 60 mm"]
radius = "12.5 mm"
tip_diameter = "6 mm"
offset = "0 0 -150 mm"
zero = "0 0 50 mm"
rotary = { B = ["-60 deg", "-30 deg", "0 deg", "30 deg", "60 deg"], C = ["0 deg", "90 deg", "180 deg", "270 deg"] }
spindle = []
"""
OFFSET, PIVOT, ZERO, BALL, REACH = (
    np.array([0, 0, -150.0]),
    np.array([0, 0, 200.0]),
    np.array([0, 0, 50.0]),
    3.0,
    15.5,
)
SPHERES = np.array([[150.0, 0, 80], [-80, 120, 140], [-60, -130, 60]])
TRUE = {"C0B": 40e-6, "A0C": -30e-6, "B0C": 25e-6}  # rad


def turn(axis: int, angle: float) -> np.ndarray:
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[[i, i, j, j], [i, j, i, j]] = [np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)]
    return out


def ball(b: float, lean: float) -> np.ndarray:
    """From X Y Z of the axes to the middle of the ball in the machine."""
    return PIVOT + turn(2, lean) @ turn(1, b) @ (OFFSET - PIVOT)


def log_line(touch: PlannedTouch, kind: str, rng: np.random.Generator) -> str:
    b, g = np.radians(touch.rotary["B"]), np.radians(touch.rotary["C"])
    way, surface = np.array(touch.way, dtype=float), np.array(touch.surface)
    axes = surface - BALL * way + ZERO - OFFSET  # where the axes should stop
    lean = turn(0, TRUE["A0C"]) @ turn(1, TRUE["B0C"])
    apart = axes + ball(b, TRUE["C0B"]) - lean @ turn(2, -g) @ SPHERES[touch.feature - 1]
    along, aside = apart @ way, apart - (apart @ way) * way
    axes = (
        axes + (-np.sqrt(REACH**2 - aside @ aside) - along + 0.3e-3 * rng.normal()) * way
    )  # it stops before the sphere
    seen = axes + (OFFSET if kind == "axes" else ball(b, 0.0)) - ZERO
    seen = seen + BALL * way
    i, j, k = touch.way
    return f"TOUCH F{touch.feature} I{i} J{j} K{k} X{seen[0]:.5f} Y{seen[1]:.5f} Z{seen[2]:.5f} B{touch.rotary['B']:g} C{touch.rotary['C']:g}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("head")
    (place / "machine.toml").write_text(MACHINE)
    (place / "plan.toml").write_text(PLAN)
    assert (
        run(
            [
                "calibrate",
                "program",
                str(place / "plan.toml"),
                "--control",
                "fanuc",
                "--out",
                str(place / "touch"),
            ]
        )
        == 0
    )
    given = load_touch_plan(place / "plan.toml")
    job = probing_job(given, given.poses, 10.0, 30.0, 20)
    for kind in ("axes", "tip"):
        rng = np.random.default_rng(4)
        (place / "touch" / f"{kind}.log").write_text(
            "\n".join(log_line(t, kind, rng) for t in job.touches) + "\n"
        )
        text = (place / "touch" / "touch.toml").read_text()
        text = text.replace('"TOUCH.LOG"', f'"{kind}.log"').replace('head = "axes"', f'head = "{kind}"')
        (place / "touch" / f"{kind}.toml").write_text(text)
    return place


def test_a_touch_of_a_turned_head_is_along_an_axis_of_the_machine_and_its_stylus_free(folder: Path) -> None:
    """B = 60 deg points the spindle from the ball to +X and up, (sin 60, 0, cos 60): a sphere cannot be touched from -X, whose normal (-1, 0, 0) is 150 deg from
    it. The ball stands at c + Ry(60) (o - c) = 200 - 350 cos 60 = 25 mm in Z and -350 sin 60 = -303.1 mm in X from the axes: over the sphere at 150 0 80 the
    axes are at X 453.1, and the program says X - 453.1 with the head taken as zero.
    """
    given = load_touch_plan(folder / "plan.toml")
    job = probing_job(given, [{"B": np.radians(60.0), "C": 0.0}], 10.0, 30.0, 20)
    ways = [t.way for t in job.touches if t.feature == 1]
    assert ways == [(-1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1)]
    above = next(t for t in job.touches if t.feature == 1 and t.way == (0, 0, -1))
    # Z of the axes 80 + 15.5 - 25 = 70.5; as if at zero the ball is 150 lower, its lowest point, which touches, 3 more, from G54 at 50: -132.5
    assert above.surface == pytest.approx((453.109, 0.0, -132.5), abs=1e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("control", CONTROLS)
def test_every_control_is_written_and_reads_back(
    folder: Path, control: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command refuses to write what reads back beside its plan; what follows the tip is ended before the first move."""
    out = folder / control
    assert (
        run(["calibrate", "program", str(folder / "plan.toml"), "--control", control, "--out", str(out)]) == 0
    )
    program = next(p for p in out.iterdir() if p.stem == "TOUCH" and p.suffix in (".nc", ".mpf", ".h"))
    ends = {"fanuc": "G49\n", "haas": "G49\n", "sinumerik": "TRAFOOF\n", "heidenhain": "M129\n"}
    text = program.read_text()
    assert 0 < text.index(ends[control]) < text.index("B-60")
    assert 'head = "axes"' in (out / "touch.toml").read_text()
    capsys.readouterr()
    assert run(["nc", str(program), "--setup", str(out / "setup.toml"), "--json"]) == 0


def test_both_logs_say_the_same(folder: Path) -> None:
    one, _ = load_recording(folder / "touch" / "axes.toml")
    other, _ = load_recording(folder / "touch" / "tip.toml")
    for axis in "XYZBC":
        assert one.run.q(axis) == pytest.approx(other.run.q(axis), abs=2e-5)  # five digits are printed
    assert one.value == pytest.approx(other.value, abs=4e-5)


@pytest.mark.parametrize("kind", ["axes", "tip"])
def test_location_errors_of_head_and_table_are_found(folder: Path, kind: str) -> None:
    path = folder / "touch" / f"{kind}.toml"
    recording, machine = load_recording(path)
    found = calibrate([recording], machine, {recording.name: load_certificate(path, recording)})
    for name, true in TRUE.items():
        _, value, u = found.band(name)
        assert abs(value[0] - true) < 3.5 * u[0], name
        assert u[0] < 3e-6


def test_a_log_that_does_not_say_what_it_is_of_is_refused(folder: Path) -> None:
    path = folder / "touch" / "axes.toml"
    bare = path.with_name("bare.toml")
    bare.write_text(path.read_text().replace('head = "axes"\n', ""))
    with pytest.raises(
        DataError, match=r'bare.toml:12: .touch. the head turns by B.*add head = "axes".*head = "tip"'
    ):
        load_recording(bare)
    still = path.with_name("machine_without.toml")
    still.write_text(MACHINE.replace("Z B t", "Z t").replace("axes.B", "# axes.B"))
    other = path.with_name("without.toml")
    text = path.read_text()
    other.write_text(
        text[: text.index("machine =")] + f'machine = "{still}"\n' + text[text.index("kind =") :]
    )
    with pytest.raises(DataError, match="no axis that turns a head; leave it out"):
        load_recording(other)
