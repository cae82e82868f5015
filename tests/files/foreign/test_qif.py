"""QIF 3.0: parts, points, machines read; results written and read back; what is broken is refused with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import data_file
from tests.files.foreign.samples import QIF
from vcmm.core.errors import DataError
from vcmm.core.text import read_text
from vcmm.files.foreign.convert import Beside, convert
from vcmm.files.foreign.exported_values import handed_over
from vcmm.files.foreign.isg import read_isg
from vcmm.files.foreign.qif import read_qif
from vcmm.files.foreign.qif_machine import read_qif_machine
from vcmm.files.foreign.qif_part import read_qif_part
from vcmm.files.foreign.qif_points import read_qif_points
from vcmm.files.foreign.qif_results import qif_text
from vcmm.files.foreign.xml import read_xml
from vcmm.files.own.scenario import load_scenario

SAMPLE = "data/formats/QIF_PTS_SAMPLE.QIF"


def written(tmp_path: Path, text: str, name: str = "part.qif") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_part_in_inches_becomes_features_and_characteristics_in_mm(tmp_path: Path) -> None:
    drawn = read_qif_part(written(tmp_path, QIF))
    assert drawn.features["bore"] == {
        "type": "cylinder", "point": "0 0 0 mm", "axis": [0.0, 0.0, 1.0], "diameter": "25.4 mm", "inside": True,
        "length": "50.8 mm",
    }  # fmt: skip
    assert drawn.features["top"]["point"] == "0 0 50.8 mm"
    assert drawn.characteristics == [
        {"name": "D1", "type": "size", "of": "bore", "limits": ["-0.0254 mm", "0.0254 mm"]},  # 0.999 and 1.001 in
        {"name": "P1", "type": "perpendicularity", "of": "bore", "zone": "0.0508 mm", "datums": ["top"], "material": "M"},
    ]  # fmt: skip
    assert any("LinearCoordinate X1: no such characteristic here; left out" in n for n in drawn.notes)
    assert any("top: the file states no extent" in n for n in drawn.notes)


def test_the_scenario_of_a_part_is_read_without_a_problem(tmp_path: Path) -> None:
    made = convert(written(tmp_path, QIF))
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    scenario = load_scenario(tmp_path / "scenario.toml")
    assert [c.name for c in scenario.part.characteristics] == ["D1", "P1"]
    assert set(scenario.plan.styli) == {"down"}
    assert len(scenario.plan.steps) == 2
    assert (tmp_path / "part.toml").read_text().count("# ") >= len(made.notes)


def test_a_characteristic_can_be_left_out_with_its_reason(tmp_path: Path) -> None:
    made = convert(written(tmp_path, QIF), Beside(without={"P1": "contradicts the drawing"}))
    assert 'name = "P1"' not in made.texts["part.toml"]
    assert "P1: contradicts the drawing; left out" in made.notes


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('versionQIF="3.0.0"', 'versionQIF="2.1"', "version 3 is read"),
        ("<Diameter>1</Diameter>", "<Diameter>wide</Diameter>", "is not a finite number"),
        ("<Diameter>1</Diameter>", '<Diameter linearUnit="mm">1</Diameter>', "a unit of its own"),
        ("<Direction>0 0 1</Direction>", "<Direction>0 0 0</Direction>", "the direction has no length"),
        ("<FeatureNominalId>6<", "<FeatureNominalId>99<", 'the id "99" belongs to nothing'),
        ('id="5"', 'id="2"', 'the id "2" is used here and at'),
        ("<MinValue>0.999", "<MinValue>1.5", "hold nothing between them"),
        ("</Features>", "</Feature>", "no well-formed XML"),
        ("<QIFDocument", '<!DOCTYPE x [<!ENTITY a "aaaa">]><QIFDocument', "a document type"),
    ],
)
def test_what_is_broken_is_refused_with_its_line(tmp_path: Path, old: str, new: str, says: str) -> None:
    assert old in QIF
    path = written(tmp_path, QIF.replace(old, new, 1))
    with pytest.raises(DataError, match=says) as error:
        read_qif_part(path)
    assert str(error.value).startswith(f"{path}:")


def test_deep_xml_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="nested deeper"):
        read_xml(written(tmp_path, "<a>" * 300 + "</a>" * 300))


def test_measured_points_of_the_public_sample() -> None:
    """Holes scanned on a real machine: the sample's own errors are told, its points are centres of a tip of 2.4998 mm."""
    found = read_qif_points(data_file(SAMPLE))
    (part,) = found.parts
    assert found.tip_radius == pytest.approx(2.49978271104, abs=1e-12)
    assert part.features is not None
    assert [part.features.count(n) for n in ("CIRCLE1", "DATUMA", "CYL_1")] == [
        219,
        6,
        18,
    ]
    assert any('the point set "828" of POINT5 is not in these results' in n for n in found.notes)


def test_diameters_agree_with_the_other_program(tmp_path: Path) -> None:
    """Ours from the raw points against what the other program reported: least squares, tip along the found normal.

    12.095569950907 and 12.068425921099 mm belong to bores 0.16 and 0.29 mm off their place: along the nominal normals
    they would read 1.4 and 3.7 um less.
    """
    from vcmm.answer.inference.points import task_and_rows
    from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points

    path = data_file(SAMPLE)
    made = convert(path)
    text = made.texts["part.toml"]
    head, *rows = text.split("\n[[characteristics]]")
    sizes = [r for r in rows if 'type = "size"' in r and "CYL_1" not in r]
    made.texts["part.toml"] = "\n[[characteristics]]".join([head, *sizes])
    for name, content in made.texts.items():
        (tmp_path / name).write_text(content, encoding="utf-8")
    scenario = load_scenario(tmp_path / "scenario.toml")
    task = task_and_rows(scenario, read_qif_points(path).parts[0], tip_centres=True)[0]
    reported = {"DIA_": 12.091599179226, "DIA_CIRCLE1": 12.095569950907, "DIA_2": 12.068425921099}
    indicated = measured_points(task, task.machine.indication_error(task.touches.run))
    found = dict(
        zip((c.name for c in task.part.characteristics), evaluate_all(task, fit_features(task, indicated)))
    )
    assert found == pytest.approx(reported, abs=5e-9)


def test_21_errors_of_a_machine_by_their_names() -> None:
    """Signs: a squareness above 90 deg turns Y away from +X (C0Y +), Z away from +Y (A0Z +), Z away from +X (B0Z -)."""
    path = data_file("data/formats/constructed/qif_cmm_21errors.qif")
    machine = read_qif_machine(path)
    q, v = machine.curves["X"]["EXX"]
    assert (q[1], v[1]) == (100.0, 0.0016692)
    assert machine.curves["Z"]["EBZ"][1][1] == 4.904e-06  # ZAxisYaw
    assert machine.squareness == {"C0Y": 4.8e-06, "B0Z": 3.1e-06, "A0Z": 2.2e-06}
    assert machine.mpe == pytest.approx((1.9, 0.0033))  # 1.9 um + 3.3 um/m, that is L/303 um


def test_the_machine_file_holds_the_same_errors(tmp_path: Path) -> None:
    path = data_file("data/formats/constructed/qif_cmm_21errors.qif")
    made = convert(path)
    table = tmp_path / "errors.csv"
    table.write_text(made.texts["errors.csv"], encoding="utf-8")
    back, machine = read_isg(table), read_qif_machine(path)
    assert back.constants == machine.squareness
    assert sum(len(t.values) for t in back.tables) == 18
    for t in back.tables:
        for name, values in t.values.items():
            assert values == pytest.approx(machine.curves[t.arguments[0]][name][1], abs=1e-15)


DOCUMENT = {
    "schema": "vcmm.uncertainty/1",
    "characteristics": [
        {
            "name": "D1", "type": "size", "nominal_mm": 25.4, "value_mm": 25.41, "measured_mm": 25.411, "bias_mm": 0.001,
            "u_mm": 0.0005, "U_mm": 0.001, "k": 2.0, "p": 0.95, "interval_mm": [25.41, 25.412],
            "tolerance_mm": [25.3746, 25.4254], "decision": "conforms",
        },
        {
            "name": "P1", "type": "perpendicularity", "nominal_mm": 0.0, "value_mm": 0.06, "bias_mm": None, "u_mm": None,
            "U_mm": None, "k": None, "p": 0.95, "interval_mm": None, "tolerance_mm": [0.0, 0.0508],
            "decision": "does not conform",
        },
    ],
}  # fmt: skip


def test_results_are_written_with_their_uncertainty_and_read_back(tmp_path: Path) -> None:
    made = convert(written(tmp_path, QIF))
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    part = load_scenario(tmp_path / "scenario.toml").part
    text, notes = qif_text(part, handed_over(DOCUMENT), "seed")
    assert not notes
    assert text == qif_text(part, handed_over(DOCUMENT), "seed")[0]
    back = written(tmp_path, text, "results.qif")
    values = {
        n.name: n.one("Value")
        for n in read_qif(back).root.below()
        if n.name.endswith("CharacteristicMeasurement")
    }
    size = values["DiameterCharacteristicMeasurement"]
    assert size is not None
    assert size.text == "25.411"
    assert size.attributes == {"combinedUncertainty": "0.0005", "meanError": "0.001"}
    form = values["PerpendicularityCharacteristicMeasurement"]
    assert form is not None
    assert form.attributes == {}
    assert [n.text for n in read_qif(back).root.below() if n.name == "InspectionStatusEnum"] == ["FAIL"]
    again = read_qif_part(back)
    assert again.features["bore"]["diameter"] == "25.4 mm"
    assert again.features["bore"]["length"] == "50.8 mm"
    assert again.characteristics[0]["limits"] == ["-0.0254 mm", "0.0254 mm"]
    assert again.characteristics[1]["datums"] == ["top"]


def test_several_parts_are_told_apart_by_their_serial_numbers(tmp_path: Path) -> None:
    made = convert(written(tmp_path, QIF))
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    rows = DOCUMENT["characteristics"]
    handed = handed_over(
        {
            "schema": "vcmm.uncertainty/1",
            "parts": [{"part": n, "characteristics": rows} for n in ("a&b", "c")],
        }
    )
    text, _ = qif_text(load_scenario(tmp_path / "scenario.toml").part, handed, "s")
    root = read_qif(written(tmp_path, text, "r.qif")).root
    assert [n.text for n in root.below() if n.name == "SerialNumber"] == ["a&b", "c"]
    components = {
        n.attributes["id"]: n.words("SerialNumber") for n in root.below() if n.name == "ActualComponent"
    }
    results = root.many("Results/MeasurementResultsSet/MeasurementResults")
    assert [components[r.words("ActualComponentIds/Id")] for r in results] == ["a&b", "c"]
    lists = [n for n in root.below() if "n" in n.attributes]
    assert all(int(n.attributes["n"]) == len(n.children) for n in lists)


def test_lists_of_the_written_document_have_their_counts(tmp_path: Path) -> None:
    """Every list of QIF states how many entries it has; ids are unique and idMax is the largest."""
    made = convert(written(tmp_path, QIF))
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    text, _ = qif_text(load_scenario(tmp_path / "scenario.toml").part, handed_over(DOCUMENT), "s")
    document = read_qif(written(tmp_path, text, "r.qif"))
    counted = [n for n in document.root.below() if "n" in n.attributes]
    assert counted
    assert all(int(n.attributes["n"]) == len(n.children) for n in counted)
    assert int(document.root.attributes["idMax"]) == max(int(i) for i in document.by_id)
    assert "&" not in read_text(tmp_path / "r.qif").replace("&amp;", "")


def test_points_are_read_by_ranges_and_indices(tmp_path: Path) -> None:
    """A range counts from one and holds both ends, an index is one point; inches are mm here."""
    results = """<Results><MeasurementResultsSet n="1"><MeasurementResults id="30"><MeasuredFeatures n="1">
<PlaneFeatureMeasurement id="31"><FeatureItemId>4</FeatureItemId><PointList n="2"><RangePointSetId range="2 3">33</RangePointSetId>
<SinglePointSetId index="1">33</SinglePointSetId></PointList></PlaneFeatureMeasurement></MeasuredFeatures>
<MeasuredPointSets n="1"><MeasuredPointSet id="33" count="3"><Points>1 0 2 2 0 2 3 1 2</Points></MeasuredPointSet></MeasuredPointSets>
</MeasurementResults></MeasurementResultsSet></Results></QIFDocument>"""
    found = read_qif_points(written(tmp_path, QIF.replace("</QIFDocument>", results)))
    assert found.tip_radius is None
    assert found.parts[0].features == ("top",) * 3
    np.testing.assert_allclose(found.parts[0].points[:, 0], [50.8, 76.2, 25.4], atol=1e-12)


def test_a_flag_that_contradicts_the_file_is_refused_and_its_gaps_are_told(tmp_path: Path) -> None:
    """A QIF file states its own tip; features without points are told with the result, not only by convert."""
    from vcmm.core.errors import UsageError
    from vcmm.face.given_files import given_points

    results = """<Results><MeasurementResultsSet n="1"><MeasurementResults id="30"><MeasuredFeatures n="2">
<PlaneFeatureMeasurement id="31"><FeatureItemId>4</FeatureItemId><PointList n="1"><WholePointSetId>33</WholePointSetId></PointList></PlaneFeatureMeasurement>
<CylinderFeatureMeasurement id="32"><FeatureItemId>7</FeatureItemId><PointList n="1"><WholePointSetId>99</WholePointSetId></PointList></CylinderFeatureMeasurement>
</MeasuredFeatures><MeasuredPointSets n="1"><MeasuredPointSet id="33" count="1"><Points>1 0 2</Points></MeasuredPointSet></MeasuredPointSets>
</MeasurementResults></MeasurementResultsSet></Results></QIFDocument>"""
    path = written(tmp_path, QIF.replace("</QIFDocument>", results))
    made = convert(written(tmp_path, QIF, "drawing.qif"))
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    scenario = load_scenario(tmp_path / "scenario.toml")
    given, centres, notes = given_points(scenario, path, False)
    assert given[0].features == ("top",)
    assert not centres
    assert 'the point set "99" of bore is not in these results' in notes[0]
    with pytest.raises(UsageError, match="leave --tip-centres out"):
        given_points(scenario, path, True)
