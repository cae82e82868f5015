"""Exports of other measuring software: what they say, what is left out, what is refused with its line."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest

from tests.plate import edited
from vcmm.answer.inference.job import absolute_values
from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.foreign.cmm_exports import exported_values
from vcmm.files.own.scenario import load_scenario

HEAD = "planid\tpartnb\tid\ttype\tidsymbol\tactual\tnominal\tuppertol\tlowertol\tdeviation\tunit\n"
ROW = "plan\t{part}\t{id}\tD1\tdiameter\t{actual}\t30.0\t0.02\t0.0\t0.0\t{unit}\n"
REPORT = """PART NAME : plate
DIM LOC1= LOCATION OF CIRCLE BORE  UNITS=MM ,$
GRAPH=OFF  TEXT=OFF
AX    NOMINAL    +TOL     -TOL     MEAS     MAX    MIN    DEV    OUTTOL
X     15.0000   0.0100   0.0100  15.0031   15.0031 15.0031   0.0031   0.0000 ----#----
D     30.0000   0.0210   0.0000  30.0104   30.0104 30.0104   0.0104   0.0000 ----#----
END OF DIMENSION LOC1
DIM DIST1= 2D DISTANCE FROM PLANE FRONT TO CIRCLE BORE UNITS=IN,$
AX    NOMINAL    +TOL     -TOL     MEAS     DEV      OUTTOL
M     1.5748    0.0004   0.0004   1.5750   0.0002   0.0000
"""


def calypso(folder: Path, *rows: dict[str, str]) -> Path:
    path = folder / "plan_chr.txt"
    usual = {"part": "", "unit": "mm"}
    path.write_text(HEAD + "".join(ROW.format(**usual | r) for r in rows) + "END\n", encoding="utf-8")
    return path


def test_a_calypso_table(tmp_path: Path) -> None:
    """30.010 mm of part 7, 1 inch = 25.4 mm of part 8, 90 deg; a characteristic that nobody asks for."""
    path = calypso(
        tmp_path,
        {"part": "7", "id": "bore", "actual": "30.010"},
        {"part": "8", "id": "bore", "actual": "1.0", "unit": "inch"},
        {"part": "8", "id": "angle", "actual": "90", "unit": "deg"},
        {"part": "8", "id": "other", "actual": "x"},
    )
    found = exported_values(path, ["bore", "angle"])
    assert found is not None
    (first,), (second, third) = found[0]
    assert (first.part, first.number, first.where) == ("7", 30.010, f"{path}:2")
    assert second.number == pytest.approx(25.4)
    assert (third.angle, third.number) == (True, pytest.approx(math.pi / 2))
    assert "1 characteristics are not asked for and left out: other" in found[1]


def test_a_pc_dmis_report(tmp_path: Path) -> None:
    """LOC1 has two rows, so its diameter is LOC1.D; DIST1 has one: 1.575 in = 40.005 mm."""
    path = tmp_path / "report.txt"
    path.write_text(REPORT)
    found = exported_values(path, ["LOC1.D", "DIST1"])
    assert found is not None
    ((bore, distance),) = found[0]
    assert (bore.name, bore.number, bore.where) == ("LOC1.D", 30.0104, f"{path}:6")
    assert distance.number == pytest.approx(40.005)
    assert "LOC1.X" in found[1]
    assert exported_values(path, ["DIST1.M"])[0][0][0].number == pytest.approx(40.005)  # type: ignore[index]


def test_the_head_of_a_new_page_within_a_block_is_no_row(tmp_path: Path) -> None:
    """So the block still has one row, and is known by its name alone."""
    path = tmp_path / "report.txt"
    head, one = (
        "AX    NOMINAL    MEAS   +TOL   -TOL    DEV   OUTTOL\n",
        "D  30.0 30.0021 0.011 0.01 0.0021 0.0\n",
    )
    page = "\nPART NAME  : PLATE      PAGE 2\nREV NUMBER : A\nSER NUMBER :\n"
    path.write_text(
        f"DIM LOC1= LOCATION OF CYLINDER BORE  UNITS=MM ,$\n{head}{one}{page}END OF DIMENSION LOC1\n"
    )
    found = exported_values(path, ["LOC1"])
    assert found is not None
    assert [v.number for v in found[0][0]] == [30.0021]
    assert found[1] == ""


POSITION = """DIM POS1= TRUE POSITION OF CIRCLE BORE  UNITS=MM ,$
GRAPH=OFF  TEXT=OFF  MULT=10.00  OUTPUT=BOTH  DEV PERPEN CENTERLINE=ON
AX     NOMINAL       MEAS       +TOL       -TOL      BONUS        DEV     OUTTOL
X      15.0000    15.0031                                      0.0031
Y      20.0000    19.9990                                     -0.0010
DF     30.0000    30.0104     0.0210     0.0000     0.0104     0.0104     0.0000
TP         MMC     0.0065     0.0500                0.0104     0.0065     0.0000
END OF DIMENSION POS1
DIM ANGL1= 2D ANGLE (TRUE) FROM LINE LIN1 TO LINE LIN2  ,$
AX    NOMINAL    +TOL     -TOL     MEAS     DEV      OUTTOL
A     45,0000    0,1000   0,1000  45,0180   0,0180   0,0000
FCFFLAT1 FLATNESS OF PLN1
"""


def test_rows_of_a_position_leave_cells_empty(tmp_path: Path) -> None:
    """Each number under its heading, proved by deviation = measured - nominal; an angle without UNITS is in degrees."""
    path = tmp_path / "report.txt"
    path.write_text(POSITION)
    found = exported_values(path, ["POS1.X", "POS1.DF", "POS1.TP", "ANGL1"])
    assert found is not None
    ((x, diameter, position, angle),) = found[0]
    assert [x.number, diameter.number, position.number] == [15.0031, 30.0104, 0.0065]
    assert (angle.angle, angle.number) == (True, pytest.approx(math.radians(45.018)))
    assert "POS1.Y" in found[1]
    assert ":12: FCFFLAT1: no table with FEATURE and MEAS follows" in found[1]


@pytest.mark.parametrize("shift", [-7, 9])
def test_a_short_row_that_does_not_stand_under_its_heading_is_refused(tmp_path: Path, shift: int) -> None:
    """Moved by most of a column, X would read as another number: it is refused where it is asked for, and only there."""
    row = "X      15.0000    15.0031                                      0.0031"
    moved = row[:7] + row[7:].replace(
        "    15.0031", " " * (4 + shift) + "15.0031" if shift > 0 else "15.0031" + " " * 4
    )
    path = tmp_path / "report.txt"
    path.write_text(POSITION.replace(row, moved))
    assert exported_values(path, ["POS1.DF"]) is not None
    with pytest.raises(DataError, match=r"not each under its heading|no measured value"):
        exported_values(path, ["POS1.X"])


def test_another_nominal_and_a_wrong_deviation_are_told(tmp_path: Path) -> None:
    """50.0021 - 50.0100 = -0.0079 mm, and the row says 0.0021; the scenario has 50. Part 17 is right: 50.0012 - 50 = 0.0012."""
    path = tmp_path / "ring_chr.txt"
    row = "ring\t{}\tbore\tD1\tdiameter\t{}\t{}\t0,004\t-0,004\t{}\tmm\n"
    path.write_text(
        HEAD
        + row.format("17", "50,0012", "50,0000", "0,0012")
        + row.format("18", "50,0021", "50,0100", "0,0021")
    )
    found = exported_values(path, ["bore"], {"bore": 50.0})
    assert found is not None
    first, second = found[1].split(f"; {path}:3: ")
    assert first.startswith(f"{path}:3: bore: nominal 50,0100 mm is not that of the scenario, 50 mm")
    assert "deviation 0,0021 is not actual - nominal = 50,0021 - 50,0100 = -0.0079 mm" in second
    assert f"{path}:2:" not in found[1]


def test_the_same_of_a_report_of_pc_dmis(tmp_path: Path) -> None:
    """30.0104 - 30.0000 = 0.0104 mm where DEV says 0.0140; 1.5748 in = 39.99992 mm is 40 mm as far as it is written (0.00005 in)."""
    path = tmp_path / "report.txt"
    nominals = {"LOC1.D": 30.0, "DIST1": 40.0}
    path.write_text(REPORT)
    found = exported_values(path, list(nominals), nominals)
    assert found is not None
    assert "is not" not in found[1]
    path.write_text(REPORT.replace("30.0104   0.0104", "30.0104   0.0140"))
    found = exported_values(path, list(nominals), nominals | {"DIST1": 40.01})
    assert found is not None
    assert f"{path}:6: LOC1.D: DEV 0.0140 is not MEAS - NOMINAL = 30.0104 - 30.0000 = 0.0104 mm" in found[1]
    assert (
        f"{path}:10: DIST1: NOMINAL 1.5748 in is not that of the scenario, 1.57519685 in" in found[1]
    )  # 40.01 / 25.4


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252", "utf-8-sig"])
def test_decimal_commas_and_encodings(tmp_path: Path, encoding: str) -> None:
    text = (HEAD + ROW.format(part="Gehäuse", id="Bohrung Ø30", actual="30,0104", unit="mm")).replace(
        "\n", "\r\n"
    )
    path = tmp_path / "plan_chr.txt"
    path.write_bytes(text.encode(encoding))
    found = exported_values(path, ["Bohrung Ø30"])
    assert found is not None
    ((value,),) = found[0]
    assert (value.part, value.number, value.where) == ("Gehäuse", 30.0104, f"{path}:2")
    assert ("read as Windows-1252" in found[1]) == (encoding == "cp1252")


def test_a_whole_table_with_all_columns(tmp_path: Path) -> None:
    """The heading and a row as a converter in use publishes them: 45 columns and a tab at the end, the rows cut after the groups."""
    first = "planid partnb id type idsymbol actual nominal uppertol lowertol deviation exceed warningLimitCF featureid featuresigma"
    more = "comment link linkmode mmc useruppertol userlowertol fftphi fftphiunit zoneroundnessangle groupname groupname2 datumAid"
    last = (
        "datumBid datumCid natuppertolid natlowertolid decimalplaces featurePosX featurePosY featurePosZ unit"
    )
    head = [*f"{first} {more} {last}".split(), *(f"group{i}" for i in range(1, 11))]
    cells = dict.fromkeys(head[:37], "") | {
        "planid": "p",
        "partnb": "815",
        "id": "bore",
        "actual": "16.0012",
        "unit": "mm",
    }
    path = tmp_path / "p_chr.txt"
    path.write_text("\t".join(head) + "\t\n" + "\t".join(cells.values()) + "\nEND\n")
    found = exported_values(path, ["bore"])
    assert found is not None
    assert [(v.part, v.number) for v in found[0][0]] == [("815", 16.0012)]


def test_evaluate_takes_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = edited(tmp_path)
    rows = ({"part": p, "id": n, "actual": a} for p, n, a in (("a", "bore diameter", "30.010"), ("b", "bore diameter", "30.012"), ("b", "top", "0.1")))  # fmt: skip
    path = calypso(tmp_path, *rows)
    assert run(["evaluate", str(scenario), "--values", str(path), "--trials", "2000", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [p["characteristics"][0]["measured_mm"] for p in found["parts"]] == [30.010, 30.012]
    assert any("left out: top" in w for w in found["warning_texts"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + ROW.format(part="", id="bore", actual="3o.0", unit="mm"), ':2: "3o.0" in column actual is not a number'),
        (HEAD + ROW.format(part="", id="bore", actual="30.0", unit="furlong"), ':2: the unit "furlong" is not known'),
        (HEAD + 2 * ROW.format(part="", id="bore", actual="30.0", unit="mm"), ':3: "bore" is already in'),
        (HEAD + "plan\t\n", ":2: the row has no id"),
        (HEAD + ROW.format(part="", id="bore", actual="1.234,5", unit="mm"), ':2: "1.234,5" in column actual is not a number'),
        (HEAD + ROW.format(part="", id="bore", actual="30.0", unit=""), ":2: no unit is stated"),
        ("planid\tpartnb\tfeatureid\tx\ty\n1\t2\t3\t4\t5\n", ":1: this table of CALYPSO holds features or head data"),
        (HEAD + ROW.format(part="", id="Bohrung", actual="30.0", unit="mm"), "it holds none of the characteristics of the part (bore)"),
        (REPORT.replace("LOC1", "bore").replace("X     15.0000   0.0100   0.0100  15.0031   15.0031 15.0031   0.0031   0.0000 ----#----\n", "").replace("30.0104   30.0104 30.0104   0.0104   0.0000 ----#----", "30.01"), ":5: 5 cells where the heading names 9, and not each"),
        (REPORT.replace("DIST1", "bore").replace("MEAS     DEV", "WERT     DEV"), ":10: the heading of bore has no column MEAS"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "export.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError) as caught:
        exported_values(path, ["bore"])
    assert message in str(caught.value)


def test_a_plain_table_is_none_of_them(tmp_path: Path) -> None:
    path = tmp_path / "values.csv"
    path.write_text("characteristic,value_mm\nbore,30\n")
    assert exported_values(path, ["bore"]) is None


FRAMES = """PART NAME : plate
FCFLOC1 Size   MM   10 0.1/0
FEATURE      NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL
CIR1         10.0000     0.1000     0.0000    10.0600     0.0600     0.0000
FCFLOC1 Position   MM   dia 0.2 (M) A B C
FEATURE      NOMINAL       +TOL       -TOL      BONUS       MEAS        DEV     OUTTOL
CIR1          0.0000     0.2000     0.0000     0.0600     0.2500     0.2500     0.0000
FCFLOC1 Datum Shift
SEGMENT     SHIFT X     SHIFT Y
Position     0.0000      0.0000
FCFLOC1 Summary FIT TO DATUMS=ON, DEV PERP CENTERLINE=OFF
FEATURE   AX     NOMINAL       MEAS        DEV
CIR1      X      15.0000    15.1000     0.1000
CIR1      Y      20.0000    20.0750     0.0750
FCFFLAT1   IN   .001
FEATURE      NOMINAL       +TOL       -TOL       MEAS        DEV     OUTTOL
PLN1          0.0000     0.0010     0.0000     0.0004     0.0004     0.0000
PLN2          0.0000     0.0010     0.0000     0.0006     0.0006     0.0000
"""


def test_geometric_tolerances_of_a_report(tmp_path: Path) -> None:
    """A bore of 10.00 to 10.10 mm, found as 10.06 and 0.25 off its place: 2 sqrt(0.1^2 + 0.075^2) = 0.25; its size pays 0.06."""
    path = tmp_path / "report.txt"
    path.write_text(FRAMES)
    names = ["FCFLOC1.Size", "FCFLOC1.Position", "FCFLOC1.CIR1.X", "FCFFLAT1.PLN2", "FCFLOC1.Position.CIR1"]
    found = exported_values(path, names[:4])
    assert found is not None
    ((size, position, x, flat),) = found[0]
    assert [size.number, position.number, x.number] == [10.06, 0.25, 15.1]
    assert (position.bonus, size.bonus) == (0.06, None)
    assert flat.number == pytest.approx(0.0006 * 25.4)
    assert "FCFLOC1.CIR1.Y" in found[1]
    assert "FCFFLAT1.PLN1" in found[1]
    long = exported_values(path, names[4:])
    assert long is not None
    assert long[0][0][0].number == 0.25


@pytest.mark.parametrize(
    ("material", "bonus", "right"), [("M", True, 0.19), ("", True, 0.25), ("M", False, None)]
)
def test_what_the_size_pays_for_is_taken_off(
    tmp_path: Path, material: str, bonus: bool, right: float | None
) -> None:
    """docs/drawing.md: 0.25 off with 0.06 of the size to spare needs a zone of 0.19; without the column it is not known."""
    words = f'material = "{material}"\n' if material else ""
    more = f'[[part.characteristics]]\nname = "FCFLOC1.Position"\ntype = "position"\nof = "bore"\ndatums = ["top", "front"]\nzone = "0.2 mm"\n{words}[pose]\n'
    scenario = load_scenario(edited(tmp_path, ("[pose]\n", more)))
    path = tmp_path / "report.txt"
    path.write_text(FRAMES if bonus else FRAMES.replace("BONUS", "OTHER"))
    found = exported_values(path, ["FCFLOC1.Position"])
    assert found is not None
    if right is None:
        with pytest.raises(DataError, match="the heading has no column BONUS"):
            absolute_values(scenario, found[0][0])
    else:
        assert absolute_values(scenario, found[0][0])["FCFLOC1.Position"] == pytest.approx(right)
