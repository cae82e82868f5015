"""The loop runs to its end whatever is concealed in the part: what a diagnosis writes, cut and compensate take."""

from __future__ import annotations

import json

import pytest

import vcmm
from tests.compensation import block
from tests.face.cli.test_loop import KNOWN, SCATTER
from tests.shop.machining.concealed_catalogue import PER, concealed, points_file
from vcmm.core.declaration import reported_name
from vcmm.face.cli import run

EFFECTS = {e.id: e for e in concealed() if reported_name(type(e)) == e.name}
CASES = [
    pytest.param(
        name, PER[(k + seed) % len(PER)], seed, marks=pytest.mark.thorough if seed == 1 else pytest.mark.count
    )
    for seed in (1, 2)
    for k, name in enumerate(EFFECTS)
]
QUICK = ("spindle_growth[Z]", "move", 1)


def to_the_end(folder, capsys, name: str, per: str, seed: int) -> dict:
    """The document of the loop of a part in which an effect is concealed; skips where it does not show in the block."""
    path = block.write(folder, SCATTER, scenario=KNOWN)
    points = points_file(folder, vcmm.load_cut(path), EFFECTS[name], per, seed)
    if points is None:
        pytest.skip(f"{name} does not show in this part")
    code = run(["loop", str(path), "--measured", str(points), "--out", str(folder / "next"), "--json"])
    said = capsys.readouterr()
    assert code in (0, 1), said.err
    return json.loads(said.out)


def check(found: dict) -> None:
    """Either there is a program with its proof, or it says why not; the machine file that was written has been cut with."""
    assert (found["program"] is None) == bool(found["refused"]) == (found["part_next"] is None)
    assert found["proof"]["by"] == "cut"
    if found["part_next"] is not None:
        allowed = found["part_next"]["allowed_um"]
        assert found["part_next"]["largest_um"] <= max(found["proof"]["before"]["largest_um"], allowed)
    assert (found["machine"] is not None) == any(a["written"] for a in found["found"]) or found["found"][0][
        "effect"
    ] == "map_mistake"


@pytest.mark.thorough
def test_a_growth_with_scatter_per_move_comes_to_its_end(tmp_path, capsys):
    check(to_the_end(tmp_path, capsys, *QUICK))


@pytest.mark.parametrize(("name", "per", "seed"), CASES, ids=lambda v: str(v))
def test_every_effect_that_can_show_in_a_part_comes_to_its_end(tmp_path, capsys, name, per, seed):
    check(to_the_end(tmp_path, capsys, name, per, seed))
