"""The tables of a cut, from a result made by hand."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.show.tables.test_uncertainty import result
from vcmm.shop.machining.result import SurfaceExtremes
from vcmm.show.tables import cut as tables
from vcmm.show.tables.table import in_terminal, on_page

SHARES = {"machine": 0.75, "tool": 0.25, "setup": 0.0}


def found():
    c = result()
    net = SimpleNamespace(
        feature="top", points=np.array([[1.0, 2.0, 3.0]] * 2), normals=np.array([[0.0, 0.0, 1.0]] * 2)
    )
    patch = SimpleNamespace(net=net, height=np.array([1.5e-3, math.nan]), nominal=np.array([0.0, math.nan]))
    return SimpleNamespace(
        characteristics=(c,), shares={"bore": SHARES}, repeats={"bore": 1.5e-4}, scatters={"bore": 5e-5}, patches=(patch,),
        uncertainty=SimpleNamespace(trials=1000), seconds=83.4, blank=None, own_reading=None, threads=(), grooves=(),
        surface=SurfaceExtremes(2.5, 1.0, points=1200, uncut=1, gouges=0, deep_um=5.0),
        recut=SimpleNamespace(points=3, largest=2e-6),
    )  # fmt: skip


def test_owners_and_batch():
    owners = tables.owners(found())
    assert in_terminal(owners).heads == ["characteristic", "machine", "tool", "setup"]
    assert in_terminal(owners).rows == [["bore", "75.0 %", "25.0 %", "0.0 %"]]
    assert on_page(owners).heads == [
        "characteristic",
        "u",
        "machine tool",
        "tool",
        "set-up",
        "u repeats",
        "u scatters",
    ]
    assert on_page(owners).rows == [["bore", "0.200", "75%", "25%", "0%", "0.150", "0.0500"]]
    assert in_terminal(tables.batch(found())).rows == [["bore", "0.15 µm", "0.05 µm"]]


def test_the_finished_part():
    row = in_terminal(tables.finished_part(found())).rows[0]
    assert (row[1], row[3], row[4], row[5], row[-1]) == (
        "30.00000 mm",
        "+0.02 µm",
        "0.40 µm",
        "[-0.30, +0.50] µm",
        "–",
    )
    assert in_terminal(tables.largest_contributions(found())).rows[0] == [
        "bore",
        "scatter.value",
        "touch",
        "0.15 µm",
        "90.0 %",
    ]


def test_what_the_own_machine_reads_stands_beside_it():
    c = found()
    c.own_reading = SimpleNamespace(characteristics=(replace(c.characteristics[0], value=30.00005),))
    table = in_terminal(tables.finished_part(c))
    assert dict(zip(table.heads, table.rows[0]))["own reading"] == "+0.05 µm"
    assert tables.cut_json(c)["characteristics"][0]["own_reading_mm"] == pytest.approx(5e-5)


def test_document():
    document = tables.cut_json(found())
    (c,) = document["characteristics"]
    assert c["groups"] == SHARES
    assert (c["u_repeats_mm"], c["u_scatters_mm"]) == (1.5e-4, 5e-5)
    assert document["surface"]["recut"] == {"points": 3, "largest_um": 2e-3}
    assert document["stock"] is None


def test_surface():
    rows = dict(in_terminal(tables.surface(found())).rows)
    assert rows["cycle time"] == "1 min 23.4 s"
    assert rows["contacts against displaced tools"] == "0.002 µm"
    read = list(csv.DictReader(io.StringIO(tables.surface_csv(found()))))
    assert [r["deviation_um"] for r in read] == ["1.5000", ""]
    assert (read[0]["x_mm"], read[0]["nz"], read[0]["feature"]) == ("1.000000", "1.000000", "top")


def test_owners_whose_shares_exceed_the_whole_say_what_is_done_together():
    given = found()
    given.characteristics = (result(interaction_share=-0.358),)
    given.shares = {"bore": {"machine": 1.358, "tool": 0.0, "setup": 0.0}}
    owners = tables.owners(given)
    assert in_terminal(owners).heads[-1] == "interaction"
    assert in_terminal(owners).rows == [["bore", "135.8 %", "0.0 %", "0.0 %", "-35.8 %"]]
    assert "-36%" in on_page(owners).rows[0]
    assert "100 % less the others" in owners.page_caption
