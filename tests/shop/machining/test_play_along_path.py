"""Play of an axis while a part is cut: small corrections of the path do not turn its direction round."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.compensation.test_surface import WALLS
from tests.shop.machining import shop
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up

WAY = [
    (-80, 0.0),
    (-60, 0.003),
    (-40, 0.001),
    (-20, 0.009),
    (0, 0.004),
    (20, 0.006),
    (40, -0.004),
    (60, 0.0),
    (80, -0.001),
]
PLAY = '[[effects]]\neffect = "backlash"\naxis = "Y"\ngap = "8 um"\n'


def program() -> str:
    """A slot along X whose Y is corrected by some micrometres in every block."""
    blocks = "".join(f"G1 X{x}. Y{y:.3f} F600\n" for x, y in WAY[1:])
    text = shop.SLOT.replace("G0 X-80. Y0. S3000", "G0 X-80. Y-5. S3000")  # the axis comes from -Y
    return text.replace("G1 X80. Y0. F600\n", f"G1 Y0. F600\n{blocks}")


def slides(commanded: np.ndarray, gap: float) -> np.ndarray:
    """Where a slide is that its drive pushes only once the gap is crossed: written by hand, one number at a time."""
    at, out = commanded[0] + gap / 2.0, []
    for q in commanded:
        if q - at > gap / 2.0:  # the drive pushes upwards
            at = q - gap / 2.0
        if at - q > gap / 2.0:  # and downwards
            at = q + gap / 2.0
        out.append(at)
    return np.array(out)


def test_a_wall_whose_path_is_corrected_by_less_than_the_play_follows_the_slide(tmp_path):
    """Play 8 um, Y comes from below: the slide stands at -4 um. It stays there (+3, +1 um are within the play) until 9 um push it to +5; from there
    4 um of 8 um back move nothing, nor does 6; -4 lies 8 + 5 back: the slide comes down to 0. With the sign of each block the wall would
    jump by 8 um at every one of them."""
    text = shop.SCENARIO[: shop.SCENARIO.index("[part.features]")] + WALLS
    scenario = vcmm.load_cut(shop.write(tmp_path, PLAY, text, program()))
    _, world, _ = finished_part(set_up(scenario))
    surface = world.contacts.surface(world.tool_errors)
    touches = world.measuring.task.touches
    x = np.linspace(-80.0, 80.0, 160001)
    y = np.concatenate([np.linspace(-5.0, 0.0, 5001), np.interp(x, *np.array(WAY).T)])
    by_hand = slides(y, 8e-3)[5001:]
    assert by_hand[np.searchsorted(x, [-80.0, -30.0, -20.0, 20.0, 40.0])] == pytest.approx(
        [-4e-3, 1e-3, 5e-3, 5e-3, 0.0], abs=1e-6
    )
    at = np.interp(touches.points[:, 0], x, by_hand)
    off = surface - touches.normals[:, 1] * at
    assert np.ptp(at) > 5e-3
    assert np.abs(off).max() < 0.25e-3  # the round of the tool reaches a little into the next block
