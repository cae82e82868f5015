"""Maps within the nodes of a residual field, and their U by pencil."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.build import machine
from tests.physics.factory import CUBE, PROCESS
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.face.cli import run as command
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.residual import CorrelatedField, ResidualField
from vcmm.physics.structure.scatter import Scatter
from vcmm.show.pages.field import field_page
from vcmm.show.tables.error_field import field_csv, field_json
from vcmm.task.response.volumetric import field

UM = 1e-3
HEAD = """vcmm = "machine/1"
name = "m"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["-100 mm", "500 mm"]
[axes.Y]
travel = ["-100 mm", "400 mm"]
[axes.Z]
travel = ["-300 mm", "100 mm"]
"""


def _machine(*effects: object, inputs: tuple[Input, ...] = ()) -> Machine:
    from dataclasses import replace

    return replace(machine(*effects), inputs=inputs)


def test_u_of_a_scale_by_hand() -> None:
    """u(k) = 2 um/m: at X = 1000 mm 2 um along x and nothing along y and z; the scatter of a reading is not in the map and is said."""
    known = Input("scale_factor", "X", "k", Normal(2e-6))
    mapped = field(
        _machine(
            ScaleFactor("X", 1e-5), Scatter(), inputs=(known, Input("scatter", "", "value", Normal(1e-3)))
        ),
        nodes=3,
    )
    at_end = np.abs(mapped.run.q("X")) > 999
    assert mapped.u is not None
    assert mapped.u[at_end] / UM == pytest.approx(np.broadcast_to([2.0, 0.0, 0.0], (18, 3)))
    assert mapped.u[mapped.run.q("X") == 0] == pytest.approx(0.0)
    assert mapped.left_out == ("scatter.value",)
    assert mapped.within == ()


def test_without_inputs_there_is_no_u() -> None:
    mapped = field(_machine(ScaleFactor("X", 1e-5)), nodes=2)
    assert mapped.u is None
    assert field_json(mapped)["U_mm"] is None


def test_a_correlated_field_is_mapped_within_its_nodes_with_its_own_deviation() -> None:
    """Deviation 2 um at all nodes: u = 2 um everywhere, between the nodes too."""
    effect = CorrelatedField(CUBE, np.full((8, 3), 2 * UM), 150.0)
    known = Input(effect.name, "", "values", MultivariateNormal(effect.covariance()), "run")
    mapped = field(_machine(effect, inputs=(known,)), nodes=3)
    assert mapped.within == (("X", 0.0, 400.0), ("Y", 0.0, 300.0), ("Z", -200.0, 0.0))
    assert mapped.run.n == 27
    assert mapped.diagonals == ()
    assert mapped.u == pytest.approx(2 * UM, rel=1e-6)


@pytest.mark.thorough
def test_a_process_is_mapped_with_both_shares() -> None:
    """Amplitudes 1, 0.8, 0.5 um that no reading tells, and 3 um of normal scatter: sqrt(1 + 9), sqrt(0.64 + 9), sqrt(0.25 + 9) um."""
    process = {k: v for k, v in PROCESS.items() if k != "dof"} | {"margins": "normal"}
    one = ResidualField(
        CUBE, process=process, scatter=np.full((8, 3), 3 * UM), reading_u=np.full((8, 3), 1e3)
    )
    inputs = tuple(
        Input(one.name, "", n, one.own_law(n), r) for n, r in (("systematic", "machine"), ("random", "touch"))
    )
    made = _machine(one, inputs=inputs)
    mapped = field(made, nodes=4)
    wanted = np.sqrt(np.array([1.0, 0.64, 0.25]) + 9)
    assert mapped.u / UM == pytest.approx(np.broadcast_to(wanted, (64, 3)), rel=1e-6)
    assert "U_x_um" in field_csv(made, mapped).splitlines()[0]
    page = field_page(made, mapped)
    assert "U (k = 2) in z" in page
    assert "Deformed volume" in page


def test_the_command_maps_a_field_and_takes_positions_within_it(tmp_path, capsys) -> None:
    """Both were refused: the grid of the travels and the body diagonals lie beyond the nodes."""
    nodes = ", ".join(f'"{x:g} {y:g} {z:g} mm"' for x, y, z in CUBE)
    text = f'{HEAD}[[effects]]\neffect = "correlated_field"\nlength = "150 mm"\nnodes = [{nodes}]\n'
    text += f'deviation = [{", ".join(8 * [chr(34) + "1 1 1 um" + chr(34)])}]\n[[inputs]]\neffect = "correlated_field"\nparameter = "values"\n'
    (tmp_path / "m.toml").write_text(text)
    (tmp_path / "at.csv").write_text("X_mm,Y_mm,Z_mm\n200,100,-50\n")
    (tmp_path / "off.csv").write_text("X_mm,Y_mm,Z_mm\n200,100,-50\n450,100,-50\n")
    for more, points in (([], 125), (["--at", str(tmp_path / "at.csv")], 1)):
        assert command(["field", str(tmp_path / "m.toml"), "--json", *more]) == 0
        shown = capsys.readouterr()
        found = json.loads(shown.out)
        assert found["points"] == points
        assert np.array(found["U_mm"]) == pytest.approx(2 * UM, rel=1e-5)
        assert ("within X 0 to 400 mm" in shown.err) == (not more)
    assert command(["field", str(tmp_path / "m.toml"), "--at", str(tmp_path / "off.csv")]) != 0
    assert "off.csv:3" in capsys.readouterr().err
