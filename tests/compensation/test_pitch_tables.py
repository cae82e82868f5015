"""Tables for SINUMERIK and FANUC, read back by models of the controls that are written for this test alone."""

from __future__ import annotations

import re

import pytest

from tests.compensation.mill import mill
from vcmm.core.errors import ModelLimit
from vcmm.face.cli import run as vcmm
from vcmm.files.foreign.compensation_tables import control_tables
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness


class Sinumerik:
    """K3: actual value = encoder + value of the table, so that a positive value moves the axis in the negative direction; linear between
    the points, the end values beyond them; MD32450 is put out towards minus, where it is positive when the encoder runs ahead."""

    def __init__(self, text: str, axis: str):
        values = re.findall(rf"^\$AA_ENC_COMP\[0,(\d+),{axis}1\]=(\S+)$", text, re.M)
        assert [int(n) for n, _ in values] == list(range(len(values)))
        self.values = [float(v) for _, v in values]
        self.step, self.low, self.high = (
            float(re.search(rf"^\$AA_ENC_COMP_{word}\[0,{axis}1\]=(\S+)$", text, re.M)[1])
            for word in ("STEP", "MIN", "MAX")
        )
        self.gap = float(re.search(rf"MA_BACKLASH\[0,{axis}1\]=(\S+)", text)[1])

    def drive(self, wanted: float, sense: int) -> float:
        place = min(max((wanted - self.low) / self.step, 0.0), len(self.values) - 1.0)
        k = min(int(place), len(self.values) - 2)
        value = self.values[k] + (self.values[k + 1] - self.values[k]) * (place - k)
        return wanted - value - (self.gap if sense < 0 else 0.0)


class Fanuc:
    """B-63980EN/01: going from the reference towards plus, point 3620 + k is put out within the k-th interval; towards minus what point
    3620 - k holds is taken back. Positions at whole intervals only, where it does not matter where in an interval it is put out."""

    def __init__(self, tape: str, said: str, axis: str):
        self.points = {int(n) - 10000: int(p) for n, p in re.findall(r"^N(\d+) P(-?\d+)$", tape, re.M)}
        line = next(t for t in said.splitlines() if t.startswith(f"{axis}: 3620"))
        number = {
            int(n): float(v)
            for n, v in re.findall(r"(3620|3621|3622|3623|3624|1851) = (\d+(?:\.\d+)?)", line)
        }
        self.reference, self.factor, self.interval = int(number[3620]), number[3623], number[3624]
        self.gap = number[1851]
        assert {int(number[3621]), int(number[3622])} <= set(self.points)

    def amount(self, k: int) -> float:
        """Detection units put out at k intervals from the reference."""
        if k >= 0:
            return self.factor * sum(self.points[self.reference + j] for j in range(1, k + 1))
        return -self.factor * sum(self.points[self.reference - j] for j in range(-k))

    def drive(self, k: int, sense: int) -> float:
        return k * self.interval + 0.001 * (self.amount(k) - (self.gap if sense < 0 else 0.0))


def test_the_model_of_the_fanuc_is_the_example_of_its_manual():
    """B-63980EN/01, example 1: reference 40, points 33 to 49. By pencil: 50 mm +2, 100 mm 3, 300 mm -1; -250 mm 4 (the largest of the figure)."""
    values = (2, 1, 1, -2, 0, -1, 0, -1, 2, 1, 0, -1, -1, -2, 0, 1, 2)
    tape = "\n".join(f"N{10000 + n} P{v}" for n, v in zip(range(33, 50), values))
    it = Fanuc(tape, "X: 3620 = 40, 3621 = 33, 3622 = 49, 3623 = 1, 3624 = 50.000, 1851 = 0", "X")
    assert [it.amount(k) for k in (1, 2, 6, -1, -5)] == [2, 3, -1, 1, 4]


def test_a_sinumerik_that_reads_its_table_stands_where_it_is_told():
    """X is a table, Z carries the tool, each 120 um/m too far: at 15 mm the value is +0.0018, the drive goes to 14.9982, seen at 15.0000."""
    text = control_tables(
        mill(ScaleFactor("X", 120e-6), ScaleFactor("Z", 120e-6), travel=300.0), "sinumerik", nodes=41
    ).files["AX_EEC.MPF"]
    assert "$AA_ENC_COMP[0,21,X1]=0.001800" in text  # -300 + 21 x 15 = 15
    for axis in "XZ":
        control = Sinumerik(text, axis)
        for wanted in (15.0, -120.0, 255.0, 7.5):
            assert control.drive(wanted, 1) * 1.00012 == pytest.approx(wanted, abs=1e-5)
    assert "X carries the part: what counts is the tool seen from the part" in text


def test_a_fanuc_that_reads_its_table_stands_where_it_is_told():
    """Interval 600/40 = 15 mm; 1.8 um too far each, so that the points sum up to -1.8 um a piece within half a unit of 1 um."""
    files = control_tables(
        mill(ScaleFactor("X", 120e-6), ScaleFactor("Z", 120e-6), travel=300.0), "fanuc", nodes=41
    ).files
    for axis in "XZ":
        control = Fanuc(files["pitch.txt"], files["parameters.txt"], axis)
        assert control.interval == 15.0
        for k in range(-20, 21):
            assert control.drive(k, 1) * 1.00012 == pytest.approx(15.0 * k, abs=0.5e-3 + 1e-5)
    assert (control.amount(1), control.amount(-1)) == (-2, 2)  # 1.8 um too far on either side, taken back


@pytest.mark.parametrize("sense", [1, -1])
def test_backlash_goes_into_the_parameter(sense: int):
    """A gap of 6 um: 3 um short forwards, 3 um beyond backwards, so that the true place is drive - 3 um or drive + 3 um."""
    it = mill(Backlash("X", 6e-3), travel=300.0)
    text = control_tables(it, "sinumerik", nodes=5).files["AX_EEC.MPF"]
    assert Sinumerik(text, "X").gap == pytest.approx(6e-3)
    assert Sinumerik(text, "X").drive(100.0, sense) - sense * 3e-3 == pytest.approx(100.0, abs=1e-9)
    files = control_tables(it, "fanuc", nodes=5).files
    control = Fanuc(files["pitch.txt"], files["parameters.txt"], "X")
    assert control.gap == 6
    # between the two senses; the constant 3 um belongs to the reference point, which a FANUC holds at zero
    assert control.drive(1, -1) - control.drive(1, 1) == pytest.approx(-6e-3)


def test_steep_errors_take_a_magnification_or_are_refused():
    """1 mm/m at 150 mm from point to point: 150 units; of 21 units 300/21 = 14.3, so 7 and 7 (of 20: 15 = 8 and 7, too many); 6 um are left."""
    files = control_tables(mill(ScaleFactor("X", 1e-3), travel=300.0), "fanuc", nodes=5)
    control = Fanuc(files.files["pitch.txt"], files.files["parameters.txt"], "X")
    assert control.factor == 21
    assert control.drive(2, 1) * 1.001 == pytest.approx(300.0, abs=6.5e-3)
    assert any("steps of 21 um" in t for t in files.left_out)
    with pytest.raises(ModelLimit, match="take more nodes"):
        control_tables(mill(ScaleFactor("X", 1e-2), travel=300.0), "fanuc", nodes=5)


@pytest.mark.parametrize("form", ["sinumerik", "fanuc"])
def test_what_is_not_along_the_axis_is_listed(form: str):
    assert any("squareness[C0Y]" in t for t in control_tables(mill(Squareness("C0Y", 1e-5)), form).left_out)


def test_from_the_command_line(tmp_path, capsys):
    (tmp_path / "m.toml").write_text(
        'vcmm = "machine/1"\nkind = "machine-tool"\nstructure = "w X\' b Z t"\n[axes.X]\ntravel = ["0 mm", "400 mm"]\n'
        '[axes.Z]\ntravel = ["50 mm", "200 mm"]\n[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "100 um/m"\n'
    )
    assert vcmm(["compensate", str(tmp_path / "m.toml"), "--table", "fanuc", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "pitch.txt").read_text().splitlines()[1:3] == [
        "N10001 P-1",
        "N10002 P-1",
    ]  # 10 um a piece over 40 pieces: 1 um
    assert "lies outside its travel" in capsys.readouterr().err
