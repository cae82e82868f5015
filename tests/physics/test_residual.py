"""Residual fields: exact at the nodes, Gaska's interpolation by hand, outside the hull refused; unit variance."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.residual_weights import field_weights
from vcmm.core.run import Run
from vcmm.physics.structure.residual import CorrelatedField, ResidualField

LEVELS = (0.0, 100.0, 200.0, 300.0)
COLUMNS = ((0.0, 0.0), (120.0, 0.0), (60.0, 90.0))  # staggered: one triangle
STAGGERED = np.array([[x, y, z] for x, y in COLUMNS for z in LEVELS])
CUBE = np.array([[x, y, z] for x in (0.0, 100.0) for y in (0.0, 200.0) for z in (-50.0, 0.0)])


def _run(*points: tuple[float, float, float]) -> Run:
    tip = np.array(points)
    return Run({}, np.zeros((len(tip), 3)), {f"tip_{c}_mm": tip[:, i] for i, c in enumerate("xyz")})


def _numbers(shape: tuple[int, int]) -> np.ndarray:
    return np.sin(1.3 * np.arange(np.prod(shape))).reshape(shape)


@pytest.mark.parametrize("method", ["columns-linear", "columns-nearest"])
def test_exact_at_the_nodes_of_columns(method):
    values = _numbers(STAGGERED.shape)
    field = ResidualField(STAGGERED, method, values)
    assert field.error_motion(_run(*STAGGERED))[:, :3] == pytest.approx(values, abs=1e-12)


def test_exact_at_the_nodes_of_a_grid():
    values = _numbers(CUBE.shape)
    shuffled = np.array([3, 0, 7, 1, 6, 2, 5, 4])  # the order of the nodes does not matter
    field = ResidualField(CUBE[shuffled], "trilinear", values[shuffled])
    assert field.error_motion(_run(*CUBE))[:, :3] == pytest.approx(values, abs=1e-12)


def test_linear_between_staggered_columns_by_hand():
    # x errors 3, 6, 12 um in the three columns, the same at all heights. Barycentric shares of (60, 30): the point is
    # a third of the height of the third column (30 / 90), the rest half and half: 1/3, 1/3, 1/3: (3 + 6 + 12) / 3 = 7 um.
    # (30, 45) is the middle of the edge from column 1 to 3: (3 + 12) / 2 = 7.5 um. (60, 0): (3 + 6) / 2 = 4.5 um.
    values = np.zeros(STAGGERED.shape)
    values[:, 0] = np.repeat([3e-3, 6e-3, 12e-3], 4)
    field = ResidualField(STAGGERED, "columns-linear", values)
    motion = field.error_motion(_run((60.0, 30.0, 150.0), (30.0, 45.0, 20.0), (60.0, 0.0, 280.0)))
    assert motion[:, 0] == pytest.approx([7e-3, 7.5e-3, 4.5e-3], abs=1e-15)
    assert np.all(motion[:, 1:] == 0.0)


def test_nodes_as_control_points_by_hand():
    # Four levels: a Bezier curve, its height linear in the parameter. At u = 1/2 the shares are 1/8 3/8 3/8 1/8, at u = 1/3 8/27 12/27 6/27 1/27
    # (cubes of 2/3 and 1/3). y errors 8, 0, 0, 0 um: 8/8 = 1 um at z = 150, 8 * 8/27 = 2.37037 um at z = 100, all 8 um at the node itself.
    # x errors 0, 8, 0, 0: 3 um at z = 150.
    values = np.zeros(STAGGERED.shape)
    values[::4, 1] = values[1::4, 0] = 8e-3
    field = ResidualField(STAGGERED, "columns-linear", values, curve="control")
    motion = field.error_motion(_run((60.0, 30.0, 150.0), (60.0, 30.0, 100.0), (60.0, 30.0, 0.0)))
    assert motion[:, 1] == pytest.approx([1e-3, 8e-3 * 8 / 27, 8e-3], abs=1e-14)
    assert motion[0, 0] == pytest.approx(3e-3, abs=1e-14)


def test_control_points_at_uneven_heights_keep_the_height_itself():
    # the height is one of the coordinates of the curve: errors proportional to it are reproduced exactly
    uneven = STAGGERED.copy()
    uneven[:, 2] = np.tile([0.0, 40.0, 200.0, 300.0], 3)
    values = np.zeros(uneven.shape)
    values[:, 0] = 1e-5 * uneven[:, 2]
    motion = ResidualField(uneven, "columns-linear", values, curve="control").error_motion(
        _run((60.0, 30.0, 77.0))
    )
    assert motion[0, 0] == pytest.approx(77e-5, abs=1e-12)


def test_an_unknown_curve_is_refused():
    with pytest.raises(UsageError, match='curve = "bezier"; allowed: through, control'):
        ResidualField(STAGGERED, "columns-linear", np.zeros(STAGGERED.shape), curve="bezier")


def test_curve_along_z_is_the_cubic_through_four_nodes():
    # y errors z^3 in units of 1e-9 mm: 0, 1e6, 8e6, 27e6; at z = 150 the cubic gives 150^3 = 3.375e6, at 250 15.625e6
    values = np.zeros(STAGGERED.shape)
    values[:, 1] = 1e-9 * STAGGERED[:, 2] ** 3
    field = ResidualField(STAGGERED, "columns-linear", values)
    motion = field.error_motion(_run((60.0, 30.0, 150.0), (60.0, 30.0, 250.0)))
    assert motion[:, 1] == pytest.approx([3.375e-3, 15.625e-3], abs=1e-12)


def test_z_error_is_that_of_the_nearest_node():
    # (60, 30, 140): distances to the columns 67.1, 67.1, 60 -> third column, level 100 (40 away) before 200 (60 away)
    values = np.zeros(STAGGERED.shape)
    values[:, 2] = np.arange(12.0)
    field = ResidualField(STAGGERED, "columns-linear", values)
    motion = field.error_motion(_run((60.0, 30.0, 140.0), (10.0, 5.0, 290.0)))
    assert motion[:, 2] == pytest.approx([9.0, 3.0])  # node 8 + 1; node 0 + 3


def test_nearest_column():
    # (60, 30): the third column is nearest (60 against 67.1): its 12 um; (20, 5): the first: 3 um
    values = np.zeros(STAGGERED.shape)
    values[:, 0] = np.repeat([3e-3, 6e-3, 12e-3], 4)
    motion = ResidualField(STAGGERED, "columns-nearest", values).error_motion(
        _run((60.0, 30.0, 50.0), (20.0, 5.0, 50.0))
    )
    assert motion[:, 0] == pytest.approx([12e-3, 3e-3], abs=1e-15)


def test_trilinear_by_hand():
    # corner (0 0 -50) has 8 um, all others 0: at a quarter of x, half of y, three quarters of the way down
    # (1 - 0.25)(1 - 0.5)(0.75) x 8 = 2.25 um; in the middle 8 / 8 = 1 um
    values = np.zeros(CUBE.shape)
    values[0, 0] = 8e-3
    motion = ResidualField(CUBE, "trilinear", values).error_motion(
        _run((25.0, 100.0, -37.5), (50.0, 100.0, -25.0))
    )
    assert motion[:, 0] == pytest.approx([2.25e-3, 1e-3], abs=1e-15)


@pytest.mark.parametrize("method", ["columns-linear", "columns-nearest"])
@pytest.mark.parametrize(
    "point", [(-1.0, 0.0, 50.0), (0.0, 90.0, 50.0), (60.0, 30.0, 301.0), (60.0, 30.0, -1.0)]
)
def test_outside_the_hull_is_refused(method, point):
    field = ResidualField(STAGGERED, method, np.zeros(STAGGERED.shape))
    with pytest.raises(ModelLimit, match=r"row 2: the tip at .* lies outside the hull"):
        field.error_motion(_run((60.0, 30.0, 50.0), point))


def test_outside_the_grid_is_refused():
    with pytest.raises(ModelLimit, match="outside the hull of the grid of nodes"):
        ResidualField(CUBE, "trilinear", np.zeros(CUBE.shape)).error_motion(_run((50.0, 201.0, -25.0)))


def test_a_short_column_is_not_continued():
    # the third column ends at 200: at z = 250 the field is known beside it only
    nodes = np.delete(STAGGERED, 11, axis=0)
    field = ResidualField(nodes, "columns-linear", np.zeros(nodes.shape))
    assert np.all(field.error_motion(_run((60.0, 0.0, 250.0))) == 0.0)
    with pytest.raises(ModelLimit, match=r"column of nodes at \(60 90\) mm, 0 to 200 mm high"):
        field.error_motion(_run((60.0, 30.0, 250.0)))


def test_weights_sum_to_one():
    lateral, vertical = field_weights(
        STAGGERED, "columns-linear", np.array([[50.0, 20.0, 130.0], [70.0, 40.0, 10.0]])
    )
    assert lateral.sum(axis=1) == pytest.approx(1.0)
    assert vertical.sum(axis=1) == pytest.approx(1.0)


def test_nodes_that_span_no_plane_are_refused():
    nodes = np.array([[x, 2 * x, z] for x in (0.0, 50.0, 100.0) for z in LEVELS])
    with pytest.raises(UsageError, match="lie on one line"):
        ResidualField(nodes, "columns-linear", np.zeros(nodes.shape)).error_motion(_run((50.0, 100.0, 50.0)))


def test_words_and_sizes_are_checked():
    with pytest.raises(UsageError, match="columns-linear, columns-nearest, trilinear"):
        ResidualField(CUBE, "linear", np.zeros(CUBE.shape))
    with pytest.raises(UsageError, match="7 values for 8 nodes"):
        ResidualField(CUBE, "trilinear", np.zeros((7, 3)))
    with pytest.raises(UsageError, match="do not fill a rectangular grid"):
        ResidualField(STAGGERED, "trilinear", np.zeros(STAGGERED.shape)).error_motion(_run((1.0, 1.0, 1.0)))


def test_correlated_field_keeps_the_variance_between_the_nodes():
    # values drawn with covariance K per direction: the variance anywhere is s^2 w K w = s^2; trilinear weights of
    # independent draws would leave an eighth of it in the middle of a cell
    field = CorrelatedField(CUBE, np.full((8, 3), 2e-3), 150.0, np.zeros((8, 3)))
    run = _run((50.0, 100.0, -25.0), (10.0, 190.0, -3.0), (0.0, 0.0, 0.0))
    response = field.response("values", run)[:, :3]
    variance = np.einsum("nik,kl,njl->nij", response, field.covariance(), response)
    assert variance == pytest.approx(np.broadcast_to(4e-6 * np.eye(3), (3, 3, 3)), rel=1e-6, abs=1e-14)


def test_correlated_field_at_a_node_is_the_draw_times_its_deviation():
    # nodes far apart against the length: the weight of a node at itself is 1, s is its own deviation
    deviation = 1e-3 * np.arange(1.0, 9.0)[:, None] * np.ones(3)
    values = _numbers((8, 3))
    field = CorrelatedField(CUBE, deviation, 5.0, values)
    assert field.error_motion(_run(*CUBE))[:, :3] == pytest.approx(deviation * values, abs=1e-9)


def test_correlated_field_between_two_nodes_by_hand():
    # nodes 100 mm apart, length 100: kappa = exp(-0.5) = 0.606531. In the middle k = exp(-0.125) = 0.882497 for both,
    # w = k / (1 + kappa); divided by its size sqrt(2 w^2 (1 + kappa)) it is 1 / sqrt(2 x 1.606531) = 0.557880.
    # Draws 1 and 1, s = 2 um: 2 x 2 x 0.557880 = 2.231518 um
    nodes = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0]])
    field = CorrelatedField(nodes, np.full((2, 3), 2e-3), 100.0, np.ones((2, 3)))
    assert field.error_motion(_run((50.0, 0.0, 0.0)))[0, 0] == pytest.approx(2.231518e-3, abs=1e-9)


def test_correlated_field_outside_is_refused():
    field = CorrelatedField(CUBE, np.full((8, 3), 1e-3), 150.0, np.zeros((8, 3)))
    with pytest.raises(ModelLimit, match="outside the hull of the nodes"):
        field.error_motion(_run((50.0, 100.0, 1.0)))


def test_a_field_that_names_no_nodes_covers_a_machine_on_both_sides_of_its_zero_height():
    # nothing is stated but the volume: any place from (0, 0, -10 m) to 10 m may be asked for, and nothing is added there
    places = _run((5000.0, 10.0, -5000.0), (1.0, 9999.0, 5000.0))
    for effect in (ResidualField(), CorrelatedField(length=1e3)):
        assert np.abs(effect.error_motion(places)).max() == 0.0


def test_far_from_all_nodes_the_nearest_one_speaks_alone():
    """exp(-39^2 / 2) is below the smallest number there is: the share of the nearer node is 1 nevertheless."""
    values = np.array([[1.0, 2.0, 3.0], [9.0, 9.0, 9.0]])
    nodes = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0]])
    far = CorrelatedField(nodes=nodes, length=10.0, deviation=np.ones((2, 3)), values=values)
    assert far.error_motion(_run((390.0, 0.0, 0.0)))[0, :3] == pytest.approx([1.0, 2.0, 3.0])
