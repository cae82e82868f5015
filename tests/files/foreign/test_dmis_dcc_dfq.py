"""DMIS programs and digital calibration certificates read, Q-DAS files written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.conftest import data_file
from tests.files.foreign.samples import DCC, DMIS
from tests.files.foreign.test_qif import DOCUMENT
from vcmm.core.errors import DataError, UsageError
from vcmm.files.foreign.convert import convert
from vcmm.files.foreign.dcc import dcc_results, quantities_csv, read_dcc
from vcmm.files.foreign.dmis import read_dmis
from vcmm.files.foreign.export import check_ending, dfq_text
from vcmm.files.foreign.exported_values import handed_over
from vcmm.files.foreign.xml import read_xml
from vcmm.files.own.scenario import load_scenario


def program(tmp_path: Path, text: str = DMIS) -> Path:
    path = tmp_path / "bracket.dmi"
    path.write_text(text, encoding="utf-8")
    return path


def test_features_and_tolerances_of_a_program(tmp_path: Path) -> None:
    drawn = read_dmis(program(tmp_path))
    assert drawn.features["BORE"]["length"] == "20 mm"
    assert drawn.features["BORE"]["inside"] is True
    assert drawn.features["HOLE"]["point"] == "25 25 20 mm"  # the statement goes on over a line
    assert drawn.features["TOP"]["size"] == "60 40 mm"  # from its touches
    # vertex at z = 100, half angle 45 deg: touches 10 and 30 mm below it, so 20 mm wide there and 20 mm long
    taper = drawn.features["TAPER"]
    assert (taper["point"], taper["diameter"], taper["length"], taper["angle"]) == (
        "0 0 90 mm",
        "20 mm",
        "20 mm",
        "90 deg",
    )
    by = {c["name"]: c for c in drawn.characteristics}
    assert by["DIA BORE"]["limits"] == ["-0.01 mm", "0.021 mm"]
    assert by["POS1 HOLE"]["datums"] == ["TOP", "BORE"]
    assert by["POS1 HOLE"]["material"] == "M"
    assert by["DI HOLE BORE"]["between"] == ["BORE", "HOLE"]  # the axis first
    assert any("T(UNUSED) is not asked for" in n for n in drawn.notes)
    assert any("MODE (1)" in n for n in drawn.notes)


def test_touches_become_the_points_of_the_plan(tmp_path: Path) -> None:
    made = convert(program(tmp_path))
    assert made.texts["points_TOP.csv"].splitlines()[:2] == ["x_mm,y_mm,z_mm,nx,ny,nz", "-30,-20,20,0,0,1"]
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    scenario = load_scenario(tmp_path / "scenario.toml")
    assert len(next(s for s in scenario.plan.steps if s.feature == "TOP").points) == 4


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("UNITS/MM,ANGDEC\n", "", "there is no UNITS/ statement"),
        ("UNITS/MM,ANGDEC", "UNITS/FURLONG,ANGDEC", "the length is one of"),
        ("INNER,CART,0,0,0,0,0,1,30,20", "INNER,CART,0,0,0", "numbers after CART, expected 7"),
        ("INNER,CART,0,0,0,0,0,1,30,20", "INNER,POL,0,0,0,0,0,1,30", "polar coordinates"),
        ("T(DIA)=TOL/DIAM,-0.010,0.021", "T(DIA)=TOL/DIAM,0.021,-0.010", "is not below the upper one"),
        ("TA(DIA),TA(PP)", "TA(NONE)", "T(NONE) is not defined before"),
        ("F(HOLE)=FEAT", "F(BORE)=FEAT", "defined twice"),
        ("PTMEAS/CART,-30,-20,20,0,0,1", "PTMEAS/CART,-30,-20,20", "without its vector"),
    ],
)
def test_a_broken_program_is_refused_with_its_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in DMIS
    path = program(tmp_path, DMIS.replace(old, new, 1))
    with pytest.raises(DataError, match=says.replace("(", r"\(").replace(")", r"\)")) as error:
        read_dmis(path)
    assert str(error.value).startswith(f"{path}:")


def test_quantities_of_a_certificate(tmp_path: Path) -> None:
    path = tmp_path / "ring.xml"
    path.write_text(DCC, encoding="utf-8")
    diameter, first, second = read_dcc(path)
    assert (diameter.name, diameter.unit, diameter.section) == ("diameter", "mm", "ring gauge")
    assert diameter.value == pytest.approx(50.0012)
    assert diameter.u == pytest.approx(0.00012)  # U = 0.24 um, k = 2
    assert [first.value, second.value, second.u, second.unit] == pytest.approx([0.1, 0.3, 0.1, "um"])
    assert (
        quantities_csv([diameter]).splitlines()[1]
        == "ring gauge,diameter,50.0012,mm,0.00024,2,0.00012,,,0.95"
    )


def test_the_public_example_of_a_certificate() -> None:
    found = {q.name: q for q in read_dcc(data_file("data/formats/dcc_gp_temperature_typical_v12.xml"))}
    error = found["Measurement error 1"]
    assert (error.value, error.unit, error.U, error.k, error.u) == (0.072, "K", 0.061, 2.0, 0.0305)


def test_results_for_a_certificate_are_read_back(tmp_path: Path) -> None:
    text = dcc_results("part", handed_over(DOCUMENT))
    path = tmp_path / "results.xml"
    path.write_text(text, encoding="utf-8")
    real = [n for n in read_xml(path).below() if n.name == "real"]
    assert [n.words("value") for n in real] == ["25.4110", "0.06"]  # two digits of U = 0.0010 mm
    stated = real[0].one("measurementUncertaintyUnivariate/expandedMU")
    assert stated is not None
    assert stated.words("valueExpandedMU") == "0.0010"
    assert stated.words("coverageFactor") == "2"
    assert real[1].one("measurementUncertaintyUnivariate") is None


def test_q_das_text() -> None:
    lines = dfq_text("part\n1", handed_over(DOCUMENT)).split("\r\n")
    assert lines[:2] == ["K0100 2", "K1001 part 1"]
    assert "K2112/1 -0.0254000" in lines
    assert "K2900/1 U = 0.0010 mm, k = 2, 0.95" in lines
    assert lines[-5:-1] == ["K0001/1 25.4110", "K0002/1 0", "K0001/2 0.0600000", "K0002/2 0"]
    assert "K2900/2 the interval of the true value has no end" in lines


def changed(**words: object) -> dict[str, object]:
    """The document with other words of its first characteristic alone."""
    first = {**DOCUMENT["characteristics"][0], **words}  # type: ignore[dict-item,index]
    return {**DOCUMENT, "characteristics": [first]}


def test_an_interval_that_is_not_value_and_U_stands_with_its_ends(tmp_path: Path) -> None:
    """A bias of 0.4 um was taken off: 25.411 +- 0.001 would be another interval than the one that was shown."""
    handed = handed_over(changed(interval_mm=[25.4096, 25.4116]))
    path = tmp_path / "r.xml"
    path.write_text(dcc_results("part", handed), encoding="utf-8")
    (stated,) = [n for n in read_xml(path).below() if n.name == "measurementUncertaintyUnivariate"]
    assert stated.one("expandedMU") is None
    ends = stated.one("coverageIntervalMU")
    assert ends is not None
    assert (ends.words("intervalMin"), ends.words("intervalMax")) == ("25.4096", "25.4116")
    assert "K2900/1 true value 25.4096 to 25.4116 mm, 0.95" in dfq_text("part", handed)
    (back,) = read_dcc(path)  # the ends come back; the standard uncertainty of 0.5 um is no U with k = 1
    assert (back.U, back.k, back.interval, back.p) == (None, None, (25.4096, 25.4116), 0.95)
    assert back.u == pytest.approx(5e-4)
    assert quantities_csv([back]).splitlines()[1].endswith(",mm,,,0.0005,25.4096,25.4116,0.95")


def test_ends_that_scatter_as_draws_do_keep_U_and_k(tmp_path: Path) -> None:
    """Ends 3 % of U off the middle, as 200 000 draws give them, are value +- U; 6 % are another interval.

    U = 0.96 um has the digits 0.00096 mm, so that 25.4110237 mm is 25.41102 mm (JCGM 100, 7.2.6).
    """
    first, shift = {"measured_mm": 25.4110237, "value_mm": 25.4110237, "U_mm": 0.96e-3}, 0.03 * 0.96e-3
    ends = [25.4110237 - 0.96e-3 + shift, 25.4110237 + 0.96e-3 + shift]
    handed = handed_over(changed(**first, interval_mm=ends))
    path = tmp_path / "r.xml"
    path.write_text(dcc_results("part", handed), encoding="utf-8")
    text = dfq_text("part", handed)
    assert "K2900/1 U = 0.00096 mm, k = 2, 0.95" in text
    assert "K0001/1 25.41102\r" in text
    assert "K2022/1 5\r" in text
    (found,) = read_dcc(path)  # what is written is read
    assert (found.name, found.value, found.U, found.k) == ("D1", 25.41102, 0.00096, 2.0)
    assert "D1,25.41102,mm,0.00096,2,0.00048,,,0.95" in convert(path).texts["quantities.csv"]
    far = handed_over(changed(**first, interval_mm=[end + shift for end in ends]))
    assert "true value" in dfq_text("part", far)


def test_where_coverage_is_not_shown_no_uncertainty_is_stated() -> None:
    handed = handed_over(changed(coverage_shown=False, why_not_shown="the known bias is not corrected"))
    assert "measurementUncertainty" not in dcc_results("part", handed)
    assert "K2900/1 the known bias is not corrected" in dfq_text("part", handed)


def test_several_parts_keep_their_names() -> None:
    one = DOCUMENT["characteristics"]
    handed = handed_over(
        {
            "schema": "vcmm.uncertainty/1",
            "parts": [{"part": n, "characteristics": one} for n in ("A", "B,<x>")],
        }
    )
    assert [line for line in dfq_text("p", handed).split("\r\n") if line.startswith("K0014/1")] == [
        "K0014/1 A",
        "K0014/1 B,<x>",
    ]


def test_other_endings_and_documents_are_refused() -> None:
    with pytest.raises(UsageError, match="names no format"):
        check_ending("results.txt")
    with pytest.raises(UsageError, match="only documents of vcmm evaluate"):
        handed_over({"schema": "vcmm.nc/1"})
    with pytest.raises(DataError, match="are not converted"):
        convert("part.igs")
