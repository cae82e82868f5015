"""What is written is read back the same, whatever names and numbers it holds: QIF, DCC, Q-DAS, exports, lists of points, ISG tables.

Each property runs with a few examples every day and with hundreds in `make test-all`.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.files.foreign.qif_schema import faults
from vcmm.files.foreign.convert import convert
from vcmm.files.foreign.dcc import dcc_results
from vcmm.files.foreign.export import dfq_text
from vcmm.files.foreign.exported_values import HandedValue
from vcmm.files.foreign.qif_part import read_qif_part
from vcmm.files.foreign.qif_results import qif_text
from vcmm.files.foreign.xml import read_xml
from vcmm.files.own.measured_data import read_measured_points, read_measured_values
from vcmm.part.part import Characteristic, Feature, Part

LETTERS = st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp", "Zs", "Cn", "Co"))
NAMES = st.text(LETTERS, min_size=1, max_size=12)
PLAIN = st.from_regex(r"[A-Za-z][A-Za-z0-9_.ÄÖÜäöüß]{0,11}", fullmatch=True)
LENGTHS = st.floats(-5000.0, 5000.0).map(lambda v: round(v, 6) + 0.0)
SIZES = st.floats(1e-5, 500.0)
UNITS = st.tuples(*[st.floats(-1.0, 1.0)] * 3).filter(lambda v: math.hypot(*v) > 1e-3)
POINTS = st.tuples(LENGTHS, LENGTHS, LENGTHS)


@contextmanager
def written(text: str | bytes, name: str) -> Iterator[Path]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        path.write_bytes(text.encode("utf-8") if isinstance(text, str) else text)
        yield path


@st.composite
def parts(draw: Any) -> tuple[Part, list[HandedValue]]:
    """One to four features of any kind that QIF names, each with one requirement, and what was found of it."""
    features, characteristics, values = {}, [], []
    for i, name in enumerate(draw(st.lists(PLAIN, min_size=1, max_size=4, unique=True))):
        kind, asked = draw(
            st.sampled_from([("plane", "flatness"), ("circle", "size"), ("sphere", "size"), ("cylinder", "size"), ("line", "straightness"), ("circle", "roundness"), ("cylinder", "position")])
        )  # fmt: skip
        sizes = (draw(SIZES),) if kind in ("circle", "sphere", "cylinder") else ()
        extent = {"plane": (30.0, 20.0), "cylinder": (draw(SIZES),), "line": (40.0,)}.get(kind, ())
        features[name] = Feature(
            name, kind, draw(POINTS), draw(UNITS), sizes, inside=draw(st.booleans()), extent=extent
        )
        width = draw(st.floats(1e-6, 1.0))
        limits = {"limits": (-width, width)} if asked == "size" else {"zone": width}
        c = Characteristic(f"{draw(NAMES)} {i}", asked, name, **limits)  # type: ignore[arg-type]
        nominal = 2.0 * sizes[0] if asked == "size" else 0.0
        tolerance = (nominal - width, nominal + width) if asked == "size" else (0.0, width)
        u = draw(st.none() | st.floats(1e-9, 0.1))
        characteristics.append(c)
        values.append(
            HandedValue(c.name, asked, "mm", nominal, nominal + draw(st.floats(0.0, 1.0)), draw(st.floats(-0.1, 0.1)), u,
                        None, None, 0.95, None, tolerance, draw(st.sampled_from(["", "conforms", "does not conform"])))
        )  # fmt: skip
    return Part(features, tuple(characteristics)), values


def qif_results(drawn: tuple[Part, list[HandedValue]]) -> None:
    """Nothing that the schema forbids; values to their last digit; features and limits as they were."""
    part, values = drawn
    text, _ = qif_text(part, {"": values}, "seed")
    with written(text, "r.qif") as path:
        root, back = read_xml(path), read_qif_part(path)
        assert faults(root) == []
    found = [n for n in root.below() if n.name == "Value"]
    assert [float(n.text) for n in found] == pytest.approx(
        [v.measured for v in values], rel=1e-14, abs=1e-300
    )
    assert [("meanError" in n.attributes) for n in found] == [v.u is not None for v in values]
    assert list(back.features) == list(part.features)
    for name, feature in part.features.items():
        table = back.features[name]
        assert [float(w) for w in table["point"].split()[:3]] == pytest.approx(
            feature.point, rel=1e-12, abs=1e-9
        )
        assert table.get("inside", False) == (feature.inside and bool(feature.sizes.size))
        if feature.sizes.size:
            assert float(table["diameter"].split()[0]) == pytest.approx(2.0 * feature.sizes[0], rel=1e-11)


def certificate(drawn: tuple[Part, list[HandedValue]]) -> None:
    values = drawn[1]
    with written(dcc_results("part", {"": values}), "r.xml") as path:
        real = [n for n in read_xml(path).below() if n.name == "real"]
    assert [float(n.words("value")) for n in real] == pytest.approx([v.measured for v in values], rel=1e-11)


def statistics(drawn: tuple[Part, list[HandedValue]]) -> None:
    """K-fields of Q-DAS: one line per field, whatever the names hold; values to 0.1 nm."""
    values = drawn[1]
    fields = dict(line.split(" ", 1) for line in dfq_text("part", {"": values}).split("\r\n") if line)
    assert int(fields["K0100"]) == len(values)
    for i, v in enumerate(values, 1):
        assert float(fields[f"K0001/{i}"]) == pytest.approx(v.measured, abs=5.1e-8)
        assert (
            fields[f"K2002/{i}"].split() == "".join(c if c.isprintable() else " " for c in v.name).split()
            or len(v.name) > 70
        )
        assert f"K0002/{i}" in fields


EXPORTED = st.dictionaries(PLAIN, LENGTHS, min_size=1, max_size=6)
STYLES = st.tuples(
    st.sampled_from(["utf-8", "utf-16", "cp1252", "utf-8-sig"]),
    st.booleans(),
    st.sampled_from(["\n", "\r\n"]),
)


def styled(text: str, style: tuple[str, bool, str]) -> bytes:
    return text.replace("\n", style[2]).encode(style[0])


def digits(value: float, comma: bool) -> str:
    return f"{value:.6f}".replace(".", "," if comma else ".")


def calypso(drawn: tuple[dict[str, float], tuple[str, bool, str]]) -> None:
    values, style = drawn
    rows = [f"p\t1\t{n}\tD\td\t{digits(v, style[1])}\t0\t1\t-1\tmm\n" for n, v in values.items()]
    text = (
        "planid\tpartnb\tid\ttype\tidsymbol\tactual\tnominal\tuppertol\tlowertol\tunit\t\n"
        + "".join(rows)
        + "END\n"
    )
    _exported(styled(text, style), values)


def pcdmis(drawn: tuple[dict[str, float], tuple[str, bool, str]]) -> None:
    values, style = drawn
    text = "".join(
        f"DIM {n}= 2D DISTANCE FROM A TO B UNITS=MM ,$\nAX  NOMINAL  +TOL  -TOL  MEAS  DEV  OUTTOL\n"
        f"M  {digits(0.0, style[1])} 1.0 1.0 {digits(v, style[1])} {digits(v, style[1])} 0.0\n"
        for n, v in values.items()
    )
    _exported(styled(text, style), values)


def _exported(raw: bytes, values: dict[str, float]) -> None:
    with written(raw, "export.txt") as path:
        made = convert(path)
    with written(made.texts["values.csv"], "values.csv") as path:
        (back,) = read_measured_values(path)
    assert {v.name: v.number for v in back} == values


LISTS = st.tuples(
    st.lists(st.tuples(PLAIN, POINTS, UNITS), min_size=1, max_size=6), st.booleans(), st.booleans(),
    st.sampled_from([(" ", False), ("\t", True), (";", True), (";", False), (",", False), (" ", True)]), STYLES,
)  # fmt: skip


def points(drawn: Any) -> None:
    rows, named, vectors, (mark, comma), style = drawn
    text = "".join(
        mark.join([*([n] if named else []), *(digits(v, comma) for v in (*p, *(w if vectors else ())))])
        + "\n"
        for n, p, w in rows
    )
    with written(styled(text, style), "list.asc") as path:
        made = convert(path)
    with written(made.texts["points.csv"], "points.csv") as path:
        (back,) = read_measured_points(path)
    assert back.points.tolist() == [list(p) for _, p, _ in rows]
    assert back.features == (tuple(n for n, _, _ in rows) if named else None)
    if vectors:
        assert back.normals == pytest.approx(np.array([w for _, _, w in rows]), abs=1e-6)


CHECKS: dict[str, tuple[st.SearchStrategy[Any], Callable[[Any], None]]] = {
    "QIF results": (parts(), qif_results), "DCC results": (parts(), certificate), "Q-DAS": (parts(), statistics),
    "CALYPSO": (st.tuples(EXPORTED, STYLES), calypso), "PC-DMIS": (st.tuples(EXPORTED, STYLES), pcdmis), "points": (LISTS, points),
}  # fmt: skip


def held(name: str, examples: int) -> None:
    strategy, check = CHECKS[name]

    def one(drawn: Any) -> None:
        check(drawn)

    calm = settings(
        max_examples=examples, deadline=None, database=None, suppress_health_check=[HealthCheck.too_slow]
    )
    calm(given(drawn=strategy)(one))()


@pytest.mark.thorough
@pytest.mark.parametrize("name", CHECKS)
def test_what_is_written_is_read_back(name: str) -> None:
    held(name, 10)


@pytest.mark.thorough
@pytest.mark.parametrize("name", CHECKS)
def test_what_is_written_is_read_back_often(name: str) -> None:
    held(name, 200)
