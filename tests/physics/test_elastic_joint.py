"""vcmm/physics/structure/elastic_joint.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.structure.elastic_joint import ElasticJoint


def _run(**degrees: float) -> Run:
    return Run({a: np.radians([q]) for a, q in degrees.items()}, np.zeros((1, 3)))


def test_a_joint_yields_by_cosine_and_sine_of_the_summed_angles():
    # forearm at 20 + 40 = 60 deg: 200 urad x cos 60 = 100 urad, 80 urad x sin 60 = 69.282 urad; together 169.282 urad about its own letter
    effect = ElasticJoint("B2", "B2 B3", np.array([200e-6, 80e-6]))
    motion = effect.error_motion(_run(B2=20.0, B3=40.0))
    assert motion[0] == pytest.approx([0, 0, 0, 0, 169.28203e-6, 0], abs=1e-11)
    # joints that turn about opposite directions: 20 - 40 = -20 deg, 200 cos 20 - 80 sin 20 = 187.9385 - 27.3616 = 160.5769 urad
    against = ElasticJoint("B2", "B2 -B3", np.array([200e-6, 80e-6])).error_motion(_run(B2=20.0, B3=40.0))
    assert against[0, 4] == pytest.approx(160.5769e-6, abs=1e-10)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ({"angles": "B2 X"}, '"X" is no rotary axis'),
        ({"axis": "Z"}, "no rotary axis"),
        ({"angles": " "}, "angles is empty"),
    ],
)
def test_what_is_no_joint_is_refused(words, told):
    with pytest.raises(UsageError, match=told):
        ElasticJoint(**words)
