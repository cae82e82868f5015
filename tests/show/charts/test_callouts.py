"""Labels on a part: where they point, on which side they stand, that they carry what they say."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from vcmm.show import charts
from vcmm.show.charts import Callout, callouts
from vcmm.show.charts.callouts import left_and_right, project


def test_the_eye_sees_as_pencil_has_it():
    """Azimuth -60, elevation 28 degrees: right = (sin 60, cos 60, 0); of z cos 28 is seen."""
    (x, z) = project(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert x == pytest.approx([0.866025, -0.5 * math.sin(math.radians(28))], abs=1e-6)
    assert z == pytest.approx([0.0, 0.882948], abs=1e-6)


def test_labels_stand_on_the_side_of_what_they_point_at():
    assert left_and_right([3.0, -1.0, -2.0, 5.0]) == ([1, 2], [0, 3])
    assert left_and_right([1.0]) == ([], [0])


def test_a_picture_carries_what_its_labels_say():
    cube = np.array([[[0, 0, 0], [10, 0, 0]], [[10, 0, 0], [10, 10, 0]]], float)
    labels = [
        Callout("bore $d$", "+1.2 ± 0.8 µm", [[5, 5, 0]], "conforms", "good", 1.2, 0.8),
        Callout("width", "0.4 ± 0.2 µm", [[0, 5, 0], [10, 5, 0]], "", "muted", 0.4, 0.2),
    ]
    page = charts.on_page(callouts, cube, labels, title="Results on the part")
    for words in ("bore $d$", "+1.2 ± 0.8 µm: conforms", "width", "0.4 ± 0.2 µm"):
        assert words in page
    assert "&quot;values&quot;:[1.2,0.4],&quot;U&quot;:[0.8,0.2]" in page


@pytest.mark.parametrize("count", [1, 9, 14])
def test_labels_do_not_lie_on_one_another(count: int):
    spots = np.random.default_rng(1).uniform(0, 100, (count, 3))
    labels = [Callout(f"c{i}", "1.0 ± 0.5 µm", spots[i : i + 1]) for i in range(count)]
    ax = callouts(np.zeros((1, 2, 3)), labels, title="", ax=charts.ChartSheet())
    per_unit = 780 / (ax.get_xlim()[1] - ax.get_xlim()[0])  # pixels
    names = [t for t in ax.texts if t.get_text().startswith("c")]
    for side in (-1, 1):
        heights = sorted(t.get_position()[1] for t in names if side * t.get_position()[0] > 0)
        assert all(
            per_unit * (b - a) >= 34 for a, b in itertools.pairwise(heights)
        )  # two lines of 8.5 pt at 100 px per inch
