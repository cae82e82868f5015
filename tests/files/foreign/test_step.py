"""STEP text: entities, units, tolerances with their faces. The geometry, which needs Open CASCADE, is in test_step_shapes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.hostile.judge import ask
from vcmm.core.errors import DataError, Environment
from vcmm.files.foreign.drawing import DrawnPart
from vcmm.files.foreign.part21 import Part21, Ref, read_part21
from vcmm.files.foreign.step import read_step
from vcmm.files.foreign.step_tolerances import add_tolerances

UNITS = """#1=(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.));
#2=(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.));
#3=(CONVERSION_BASED_UNIT('INCH',#4)LENGTH_UNIT()NAMED_UNIT(#5));
#4=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(25.4),#1);
#5=DIMENSIONAL_EXPONENTS(1.,0.,0.,0.,0.,0.,0.);
#6=(CONVERSION_BASED_UNIT('DEGREE',#7)NAMED_UNIT(#5)PLANE_ANGLE_UNIT());
#7=PLANE_ANGLE_MEASURE_WITH_UNIT(PLANE_ANGLE_MEASURE(0.0174532925199433),#2);
"""
SHAPE = """#10=ADVANCED_FACE('',(),#90,.T.); #11=ADVANCED_FACE('',(),#90,.T.); #12=ADVANCED_FACE('',(),#90,.T.);
#20=SHAPE_ASPECT('','',#99,.T.); #21=DATUM_FEATURE('',$,#99,.T.); #22=COMPOSITE_SHAPE_ASPECT('','',#99,.T.);
#23=DATUM('',$,#99,.F.,'A'); #24=SHAPE_ASPECT('','',#99,.T.);
#30=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#20,#98,#10);
#31=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#21,#98,#11);
#32=GEOMETRIC_ITEM_SPECIFIC_USAGE('','',#24,#98,#12);
#33=SHAPE_ASPECT_RELATIONSHIP('',$,#22,#20); #34=SHAPE_ASPECT_RELATIONSHIP('',$,#22,#24); #35=SHAPE_ASPECT_RELATIONSHIP('',$,#21,#23);
#40=DATUM_REFERENCE_COMPARTMENT('',$,#99,.F.,#23,$); #41=DATUM_SYSTEM('',$,#99,.F.,(#40));
#98=SHAPE_REPRESENTATION('',(),#97); #99=PRODUCT_DEFINITION_SHAPE('','',#96);
"""
FEATURES = {
    "bore_1": {"type": "cylinder", "point": "0 0 0 mm", "axis": [0, 0, 1], "diameter": "10 mm", "length": "20 mm", "inside": True},
    "plane_1": {"type": "plane", "point": "0 0 0 mm", "normal": [0, 0, 1], "size": "50 50 mm"},
    "bore_2": {"type": "cylinder", "point": "20 0 0 mm", "axis": [0, 0, 1], "diameter": "10 mm", "length": "20 mm", "inside": True},
}  # fmt: skip
NAMES = {10: "bore_1", 11: "plane_1", 12: "bore_2"}


def measure(number: int, value: float, unit: int = 1, name: str = "") -> str:
    return f"#{number}=(LENGTH_MEASURE_WITH_UNIT()MEASURE_REPRESENTATION_ITEM()MEASURE_WITH_UNIT(LENGTH_MEASURE({value!r}),#{unit})REPRESENTATION_ITEM('{name}'));\n"


def tied(tmp_path: Path, text: str) -> DrawnPart:
    """The characteristics of a text with faces 10 (bore), 11 (datum A), 12 (bore)."""
    path = tmp_path / "part.step"
    path.write_text(
        f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{UNITS}{SHAPE}{text}ENDSEC;\nEND-ISO-10303-21;\n"
    )
    drawn = DrawnPart("part.step", "part", features=dict(FEATURES))
    add_tolerances(read_part21(path), drawn, NAMES)
    return drawn


def dimension(values: str, aspect: int = 20, nominal: str = "") -> str:
    link = (
        "#52=DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#50,#53); #53=SHAPE_DIMENSION_REPRESENTATION('',(#54),#97);\n"
        if nominal
        else ""
    )
    return f"#50=DIMENSIONAL_SIZE(#{aspect},'diameter');\n{link}{nominal}#51=PLUS_MINUS_TOLERANCE(#60,#50);\n{values}"


def test_both_limits_may_be_above_the_nominal(tmp_path: Path) -> None:
    """Open CASCADE reads +0.02 as -0.02: the sign is that of the file."""
    drawn = tied(
        tmp_path,
        dimension(
            "#60=TOLERANCE_VALUE(#61,#62);\n" + measure(61, 0.02) + measure(62, 0.05),
            nominal=measure(54, 10.0, name="nominal value"),
        ),
    )
    assert drawn.characteristics == [
        {"name": "diameter #50", "type": "size", "of": "bore_1", "limits": ["0.02 mm", "0.05 mm"]}
    ]
    assert drawn.notes == []


def test_inches_and_another_nominal(tmp_path: Path) -> None:
    """0.4 in +- 0.001 in on a bore of 10 mm: 10.16 mm +- 0.0254 mm, so +0.1346 and +0.1854 mm from the bore as drawn."""
    text = dimension(
        "#60=TOLERANCE_VALUE(#61,#62);\n" + measure(61, -0.001, 3) + measure(62, 0.001, 3),
        nominal=measure(54, 0.4, 3, "nominal value"),
    )
    (found,) = tied(tmp_path, text).characteristics
    assert found["limits"] == ["0.1346 mm", "0.1854 mm"]


def test_a_fit_keeps_its_code_and_a_composite_gives_one_each(tmp_path: Path) -> None:
    found = tied(tmp_path, dimension("#60=LIMITS_AND_FITS('H','hole','7','');\n", aspect=22)).characteristics
    assert [(c["of"], c["limits"]) for c in found] == [("bore_1", "H7"), ("bore_2", "H7")]


def test_limits_in_a_representation(tmp_path: Path) -> None:
    """34.8 to 35.2 about 35: as ranges are written."""
    text = "#50=DIMENSIONAL_SIZE(#20,'diameter');\n#52=DIMENSIONAL_CHARACTERISTIC_REPRESENTATION(#50,#53);\n#53=SHAPE_DIMENSION_REPRESENTATION('',(#54,#55,#56),#97);\n"
    text += (
        measure(54, 10.0, name="nominal value")
        + measure(55, 10.2, name="upper limit")
        + measure(56, 9.9, name="lower limit")
    )
    (found,) = tied(tmp_path, text).characteristics
    assert found["limits"] == ["-0.1 mm", "0.2 mm"]


def test_zones_with_datums_and_modifiers(tmp_path: Path) -> None:
    text = (
        measure(70, 0.05)
        + "#71=PERPENDICULARITY_TOLERANCE('square','',#70,#20,(#41));\n#72=FLATNESS_TOLERANCE('','',#70,#21);\n"
    )
    text += "#73=(GEOMETRIC_TOLERANCE('places','',#70,#22)GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE((#41))GEOMETRIC_TOLERANCE_WITH_MODIFIERS((.MAXIMUM_MATERIAL_REQUIREMENT.))POSITION_TOLERANCE());\n"
    assert tied(tmp_path, text).characteristics == [
        {
            "name": "square",
            "type": "perpendicularity",
            "of": "bore_1",
            "zone": "0.05 mm",
            "datums": ["plane_1"],
        },
        {"name": "flatness #72", "type": "flatness", "of": "plane_1", "zone": "0.05 mm"},
        {
            "name": "places",
            "type": "position",
            "of": ["bore_1", "bore_2"],
            "zone": "0.05 mm",
            "material": "M",
            "datums": ["plane_1"],
        },
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("#71=FLATNESS_TOLERANCE('flat','',#70,#29);\n#29=SHAPE_ASPECT('','',#99,.T.);\n", "flat: no face is tied to it"),
        ("#71=(GEOMETRIC_TOLERANCE('p','',#70,#21)SURFACE_PROFILE_TOLERANCE()UNEQUALLY_DISPOSED_GEOMETRIC_TOLERANCE(#70));\n", "not disposed equally"),
        ("#71=PERPENDICULARITY_TOLERANCE('s','',#70,#20,(#42));\n#42=DATUM_SYSTEM('',$,#99,.F.,(#43));\n#43=DATUM_REFERENCE_COMPARTMENT('',$,#99,.F.,(#23,#23),$);\n", "a common datum"),
        ("#71=PERPENDICULARITY_TOLERANCE('s','',#70,#20,(#42));\n#42=DATUM_SYSTEM('',$,#99,.F.,(#43));\n#43=DATUM_REFERENCE_COMPARTMENT('',$,#99,.F.,#23,(.MAXIMUM_MATERIAL_REQUIREMENT.));\n", "a modifier on a datum"),
    ],
)  # fmt: skip
def test_what_has_no_words_here_is_said_with_its_line(tmp_path: Path, text: str, says: str) -> None:
    drawn = tied(tmp_path, measure(70, 0.05) + text)
    assert drawn.characteristics == []
    (note,) = drawn.notes
    assert says in note
    assert "part.step:" in note


def test_values_of_entities() -> None:
    text = Part21(Path("a.stp"), "#1=A('it''s; #2=B()',(1.,(2,#7)),.T.,$,*,C(3.5E-1));\n#3 = ( X(1) Y() );")
    assert text[1].parts == {"A": ["it''s; #2=B()", [1.0, [2.0, 7]], "T", None, None, 0.35]}
    assert isinstance(text[1].parts["A"][1][1][1], Ref)
    assert text[3].parts == {"X": [1.0], "Y": []}
    assert text[3].at == "a.stp:2"
    assert [e.number for e in text.of("Y", "A")] == [1, 3]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("solid cube\n", "no STEP file"),
        ("ISO-10303-21;\nDATA;\nENDSEC;\n", "holds no entity"),
        ("ISO-10303-21;\n#1=A();\n#1=B();\n", r":3: #1 is defined a second time"),
        (
            "ISO-10303-21;\n#1=A('((',\n" + "(" * 99_999 + ")" * 99_999 + ");\n",
            r":3: lists are nested deeper than 40",
        ),
        ("PK\x03\x04 a zip archive", "no STEP file"),
    ],
)
def test_no_step_file(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "a.step"
    path.write_text(text)
    with pytest.raises(DataError, match=says):
        read_part21(path)


@pytest.mark.parametrize(
    "body", ["A(1", "A((((1)))", "(A(1)", "A(" + "(" * 99 + ")" * 99 + ")", "A(1e999)", "A('x)", "12"]
)
def test_broken_values(body: str) -> None:
    text = Part21(Path("a.stp"), f"#1=B();\n#2={body};")
    with pytest.raises(DataError, match=r"a\.stp:"):
        text[2]


def test_units_that_are_none() -> None:
    text = Part21(
        Path("a.stp"),
        "#1=SI_UNIT(.KILO.,.GRAM.);\n#2=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#1);\n#3=CONVERSION_BASED_UNIT('X',#4);\n#4=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#3);\n#5=LENGTH_MEASURE_WITH_UNIT(LENGTH_MEASURE(1.),#3);",
    )
    for number in (2, 5):
        with pytest.raises(DataError, match="unit of length or angle"):
            text.measure(number)


def test_without_open_cascade_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.step"
    path.write_text("ISO-10303-21;\n#1=A();\n")
    monkeypatch.setitem(sys.modules, "OCP", None)
    with pytest.raises(Environment, match=r"pip install \"vcmm\[step\]\""):
        read_step(path)
    answer = ask(("convert", str(path), "--out", str(tmp_path / "made")))
    assert answer.code == 3
    assert not (tmp_path / "made").exists()


def test_a_fault_of_open_cascade_ends_its_child_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The child is made to end as a full stack ends it: the caller goes on with one sentence."""
    pytest.importorskip("OCP", reason='Open CASCADE is missing: pip install "vcmm[step]"')
    path = tmp_path / "a.step"
    path.write_text("ISO-10303-21;\n#1=A();\n")
    monkeypatch.setattr(
        "vcmm.files.foreign.step_faces.CHILD", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    )
    with pytest.raises(
        DataError, match=r"a\.step:1: Open CASCADE ended by a fault .*signal 11.*export it again"
    ):
        read_step(path)
    monkeypatch.setattr("vcmm.files.foreign.step_faces.CHILD", "import time; time.sleep(9)")
    monkeypatch.setattr("vcmm.files.foreign.step_faces.LONGEST", 0.2)
    with pytest.raises(DataError, match="was not done after 0 s"):
        read_step(path)
