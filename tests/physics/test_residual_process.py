"""Residual field as a process: the variance between the nodes by pencil, both shares, the laws that the effect gives itself."""

from __future__ import annotations

import json
import re
import tomllib

import numpy as np
import pytest

from tests.physics.factory import CUBE, PROCESS
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import MultivariateNormal, Normal, StudentT
from vcmm.core.residual_process import correlation_of, process_of
from vcmm.core.run import Run
from vcmm.face.cli import run as command
from vcmm.files.learned.effect_text import effect_toml
from vcmm.files.own.effects import build_effect
from vcmm.files.own.inputs import build_input
from vcmm.physics.structure.residual import ResidualField

UM = 1e-3
ANYWHERE = ((0.0, 0.0, -200.0), (200.0, 150.0, -100.0), (370.0, 20.0, -13.0), (123.0, 201.0, -77.0))


def _run(*points: tuple[float, float, float]) -> Run:
    tip = np.array(points)
    return Run({}, np.zeros((len(tip), 3)), {f"tip_{c}_mm": tip[:, i] for i, c in enumerate("xyz")})


def _field(scatter: object = UM, reading_u: float = 0.2 * UM, **words: object) -> ResidualField:
    rows = np.broadcast_to(np.asarray(scatter, dtype=float), (8, 3))
    return ResidualField(CUBE, process=PROCESS | words, scatter=rows, reading_u=np.full((8, 3), reading_u))


def _covariance(field: ResidualField, name: str, run: Run, of: np.ndarray) -> np.ndarray:
    response = field.response(name, run)[:, :3]
    return np.einsum("nik,kl,njl->nij", response, of, response)


def test_equal_scatter_at_all_nodes_is_the_same_everywhere() -> None:
    """s = 1 um at every node and the correlation of X, Y, Z: s^2 R at every place, no less between the nodes."""
    for at in (_run(*ANYWHERE),):
        seen = _covariance(_field(), "random", at, np.eye(3)) / UM**2
        assert seen == pytest.approx(np.broadcast_to(PROCESS["correlation"], (4, 3, 3)), abs=1e-9)
    # the old way in the middle of the cell: eight independent draws of weight 1/8 leave 1/8 of the variance
    old = ResidualField(CUBE).response("values", _run(ANYWHERE[1]))[0, 0]
    assert (old**2).sum() == pytest.approx(1 / 8)


def test_scatter_between_two_nodes_is_linear_in_its_square() -> None:
    """Half way along an edge between 1 um and 3 um: sqrt((1 + 9) / 2) = 2.236 um."""
    scatter = np.ones((8, 3)) * UM
    scatter[CUBE[:, 0] > 0] *= 3
    seen = _covariance(_field(scatter), "random", _run((200.0, 0.0, -200.0)), np.eye(3))
    assert np.sqrt(seen[0, 0, 0]) / UM == pytest.approx(2.2360680)


def test_what_no_reading_tells_varies_by_the_amplitude_everywhere() -> None:
    """Readings of u = 1 m tell nothing: 1.0, 0.8 and 0.5 um at the nodes and between them (bar: 2 %)."""
    field = _field(reading_u=1e3)
    seen = _covariance(field, "systematic", _run(*ANYWHERE), field.own_law("systematic").covariance)
    wanted = np.broadcast_to(np.array([1.0, 0.8, 0.5]), (4, 3))
    assert np.sqrt(np.einsum("nii->ni", seen)) / UM == pytest.approx(wanted, rel=1e-6)


def test_readings_tell_their_node_and_nothing_far_away() -> None:
    """Length 1 mm, amplitude 1 um, u = 0.5 um: at a node 1 x 0.25 / 1.25 = 0.2 um^2 are left and 1 / 1.25 = 0.8 of the reading counts;
    at a ninth node 100 mm and more away from all readings the whole 1 um^2, and nothing of them.
    """
    table = PROCESS | {"length_scales_mm": [1.0, 1.0, 1.0], "amplitude_um": [1.0, 1.0, 1.0]}
    nodes = np.vstack([CUBE, [[200.0, 150.0, -100.0]]])
    process = process_of(table, nodes, np.full((8, 3), UM), np.full((8, 3), 0.5 * UM))
    mean, covariance = process.posterior(np.full((8, 3), 2 * UM))
    assert mean[:, 0] / UM == pytest.approx([1.6] * 8 + [0.0], abs=1e-6)
    assert np.diag(covariance[1]) / UM**2 == pytest.approx([0.2] * 8 + [1.0], abs=1e-6)


def test_the_correlation_by_hand() -> None:
    """One length away q = sqrt(5): (1 + 2.236068 + 1.666667) exp(-2.236068) = 4.902735 x 0.106878 = 0.523994."""
    two = correlation_of(np.zeros((1, 3)), np.array([[100.0, 0.0, 0.0]]), np.array([100.0, 50.0, 50.0]))
    assert two[0, 0] == pytest.approx(0.523994, abs=2e-6)


def test_an_input_takes_the_law_of_the_process() -> None:
    field = _field()
    table = {"effect": "residual_field", "parameter": "random", "redraw": "touch"}
    assert build_input(table, [field]).law == StudentT(1.0, 13)
    no_dof = {k: v for k, v in PROCESS.items() if k != "dof"} | {"margins": "normal"}
    same = ResidualField(CUBE, process=no_dof, scatter=field.scatter, reading_u=field.reading_u)
    assert build_input(table, [same]).law == Normal(1.0)
    known = build_input(table | {"parameter": "systematic", "redraw": "machine"}, [field])
    assert isinstance(known.law, MultivariateNormal)
    assert known.law.covariance.shape == (24, 24)
    with pytest.raises(
        UsageError, match="does not belong to an input of residual_field: its process gives the law"
    ):
        build_input(table | {"u": "1"}, [field])


@pytest.mark.parametrize(
    ("word", "value", "says"),
    [
        ("margin", "t", 'unknown key "margin" of process. Did you mean "margins"'),
        ("margins", "cauchy", "allowed: t, normal"),
        ("dof", 2, "needs dof above 2"),
        ("margins", "normal", "which have no dof"),
        ("length_scales_mm", [1.0, 2.0], "length_scales_mm of three numbers"),
        ("amplitude_um", [1.0, 0.0, 1.0], "must be above zero"),
        ("correlation", [[1, 2, 0], [2, 1, 0], [0, 0, 1]], "no negative eigenvalue"),
    ],
)  # fmt: skip
def test_words_of_a_process_that_are_refused(word: str, value: object, says: str) -> None:
    with pytest.raises(UsageError, match=re.escape(says)):
        _field(**{word: value})


def test_rows_that_do_not_fit_are_refused() -> None:
    with pytest.raises(UsageError, match="belong to a process"):
        ResidualField(CUBE, scatter=np.ones((8, 3)))
    with pytest.raises(UsageError, match="8 rows of scatter and 7 of reading_u"):
        ResidualField(CUBE, process=PROCESS, scatter=np.ones((8, 3)), reading_u=np.ones((7, 3)))
    with pytest.raises(UsageError, match="in one plane"):
        ResidualField(CUBE * [1, 1, 0], process=PROCESS, scatter=np.ones((8, 3)), reading_u=np.ones((8, 3)))
    with pytest.raises(ModelLimit, match=r"row 2: .*outside the hull of the nodes"):
        _field().error_motion(_run(ANYWHERE[1], (200.0, 301.0, -100.0)))


def test_explain_states_laws_redraw_and_shapes(capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["explain", "residual_field"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for words in (
        'redraw = "machine"',
        'redraw = "touch"',
        "t of `dof` degrees of freedom, or normal",
        "(readings, 3) um",
        "length_scales_mm (3)",
    ):
        assert words in said, words
    assert command(["explain", "residual_field", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert "correlation (3, 3)" in next(k["doc"] for k in found["keys"] if k["key"] == "process")


def test_a_process_survives_being_written_and_read() -> None:
    """A machine file that is written anew keeps it: same tip errors, same law of the systematic share."""
    field = ResidualField(
        CUBE, systematic=UM * np.arange(24.0).reshape(8, 3), process=PROCESS, scatter=np.full((8, 3), UM), reading_u=np.full((8, 3), 0.2 * UM)
    )  # fmt: skip
    again = build_effect(tomllib.loads(effect_toml(field))["effects"][0])
    assert again.error_motion(_run(*ANYWHERE)) == pytest.approx(field.error_motion(_run(*ANYWHERE)), rel=1e-8)
    laws = [one.own_law("systematic").covariance for one in (field, again)]
    assert laws[1] == pytest.approx(laws[0], rel=1e-8)
