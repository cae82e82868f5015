"""Monte Carlo over the linear model: products of two Inputs are multiplied trial by trial."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import vcmm
from tests.build import DIAMETER, LENGTH, scenario
from vcmm.answer.evaluation import sampling
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.montecarlo import Term, simulate
from vcmm.answer.evaluation.sampling import Sampler, multiplying, pack, unpack, with_products
from vcmm.answer.evaluation.summary import Accumulator
from vcmm.core.blocks import Folder, ShardDone, Shards, Share, Sharing, blocks_of
from vcmm.core.errors import DataError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.task.measuring.settings import Settings

ALPHA = Input("scale_expansion", "X", "alpha", Normal(1e-6))
WARM = Input("channel", "", "temp_scale_x_C", Normal(0.5))


def model(characteristics=(LENGTH,)):
    # alpha = 0 and no departure of the temperature: both Inputs act through their product only
    constants = {"temp_scale_x_C": 20.0, "reading_scale_x_C": 20.0}
    one = scenario(
        ScaleExpansion("X"), inputs=(ALPHA, WARM), characteristics=characteristics, constants=constants
    )
    return build(one.task())


def test_a_product_by_hand():
    # the axis goes 104 mm: u = 104 x 1e-6 x 0.5 mm = 0.052 um, the standard deviation of a product of two normals
    one = model()
    wide, values = with_products(one, one.terms())
    assert wide[0].gain.shape[0] == len(one.q0) + 2
    start = np.concatenate([one.q0, np.zeros(2)])
    length = np.concatenate([values(b)[:, 0] for b in simulate(start, wide, seed=1, trials=200_000)])
    assert length.std() == pytest.approx(0.052e-3, rel=0.02)
    kurtosis = ((length - length.mean()) ** 4).mean() / length.var() ** 2
    assert kurtosis == pytest.approx(9.0, rel=0.1)  # 3 x 3; a normal law has 3


def test_the_layout_of_q_changes_no_digit():
    """Sizes are read from one quantity; a length adds up components and keeps the layout that its digits came from."""
    for characteristics in ((DIAMETER,), (LENGTH, DIAMETER)):
        one = model(characteristics)
        wide, values = with_products(one, one.terms())
        _, multiplied = multiplying(one, one.terms())
        assert multiplied is not None
        start = np.concatenate([one.q0, np.zeros(2)])
        block = next(simulate(start, wide, seed=1, trials=3000))
        expected = one.values(np.ascontiguousarray(multiplied(block)))
        assert expected.std(axis=0).min() > 0.0
        np.testing.assert_array_equal(values(block), expected)


def test_alone_neither_does_anything():
    one = model()
    said: list[str] = []
    sampler = Sampler(one, one.terms(), Settings(trials=2000), lambda text, share: said.append(text))
    assert sampler.alone() == pytest.approx(np.zeros((2, 1)))
    assert set(said) == {"budget"}


def test_exact_trials_see_the_same_product():
    one = model()
    settings = Settings(trials=4000, engine="exact", seed=2)
    summary = Sampler(one, one.terms(), settings, lambda text, share: None).summaries([0])[0]
    assert summary.trials == 4000
    assert summary.u == pytest.approx(0.052e-3, rel=0.1)


def test_adaptive_trials_reach_their_digits():
    one = build(replace(scenario(characteristics=(LENGTH,))).task())
    settings = Settings(digits=1)
    summary = Sampler(one, one.terms(), settings, lambda text, share: None).summaries([0])[0]
    assert summary.u == pytest.approx(1e-3 / np.sqrt(2), rel=0.05)
    assert summary.digits() >= 1


def test_a_line_of_a_position_is_the_spread_of_its_input_alone():
    # 2 hypot(x, y) about zero: alone a half-normal, 4 (1 - 2 / pi) = 1.4535; both a Rayleigh, 4 (2 - pi / 2) = 1.7168: 84.66 % each
    place = SimpleNamespace(
        q0=np.zeros(2), products=(), influences=(), values=lambda b: 2 * np.hypot(b[:, 0], b[:, 1])[:, None]
    )
    terms = [Term(n, Normal(1.0), np.eye(2)[:, [i]], [[0, 0]]) for i, n in enumerate("xy")]
    alone = Sampler(place, terms, Settings(trials=20_000, seed=1), lambda text, share: None).alone()
    assert (alone**2).ravel() == pytest.approx([0.8466, 0.8466], abs=0.02)


TRIALS = 40_000
pytestmark = pytest.mark.usefixtures("few_parts")


@pytest.fixture(autouse=True)
def small_blocks(monkeypatch):
    monkeypatch.setattr(sampling, "WORK_BLOCK", 8192)


@pytest.fixture(scope="module")
def whole():
    return vcmm.uncertainty(scenario(), trials=TRIALS)


def same(one, other) -> bool:
    """The same numbers to the last bit."""
    return all(
        (a.u, a.value, a.mean, a.interval, a.decision) == (b.u, b.value, b.mean, b.interval, b.decision)
        and (a.summary is None or np.array_equal(a.summary.histogram[1], b.summary.histogram[1]))
        for a, b in zip(one.characteristics, other.characteristics)
    )


class Counting:
    """This process as a crew that notes what it was given, in another order, and stops where it is told."""

    def __init__(self, stop_after: int = 10**9) -> None:
        self.items, self.stop_after = [], stop_after

    def __call__(self, work, payload, items):
        for i in reversed(range(len(items))):
            if len(self.items) == self.stop_after:
                raise KeyboardInterrupt
            self.items.append(items[i])
            yield i, work(payload, items[i])


def test_a_tally_survives_json_to_the_last_bit():
    one = Accumulator(0.1, 1 / 3)
    one.add(np.array([0.1, 0.3, -7.0, 1e6]))  # the last far beyond the histogram
    again = unpack(json.loads(json.dumps(pack(one))))
    assert (again.centre, again.scale, again.trials, again.minimum, again.maximum, again.sums) == (
        one.centre, one.scale, one.trials, one.minimum, one.maximum, one.sums,
    )  # fmt: skip
    assert np.array_equal(again.counts, one.counts)


def test_blocks_in_any_order_give_the_same(whole):
    crew = Counting()
    assert same(vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(crew)), whole)
    assert crew.items == blocks_of(TRIALS, 8192)[::-1]


def test_an_interrupted_job_goes_on_where_it_was(whole, tmp_path):
    first, second = Counting(stop_after=3), Counting()
    with pytest.raises(KeyboardInterrupt):
        vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(first, Folder(tmp_path)))
    (spoilt,) = tmp_path.rglob("16384-*.json")
    spoilt.write_text("half a fi")
    found = vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(second, Folder(tmp_path)))
    assert same(found, whole)
    assert sorted(second.items) == [(0, 8192), (8192, 8192), (16384, 8192)]  # the spoilt one again
    assert not list(tmp_path.rglob("*.json"))  # nothing stays when it is done


def test_blocks_of_another_seed_are_another_job(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(Counting(2), Folder(tmp_path)))
    other = Counting()
    vcmm.uncertainty(scenario(), trials=TRIALS, seed=1, sharing=Sharing(other, Folder(tmp_path)))
    assert len(other.items) == 5


def test_more_trials_use_the_blocks_of_fewer(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(Counting(4), Folder(tmp_path)))
    more = Counting()
    vcmm.uncertainty(scenario(), trials=2 * TRIALS, sharing=Sharing(more, Folder(tmp_path)))
    assert (
        len(more.items) == len(blocks_of(2 * TRIALS, 8192)) - 3
    )  # all full blocks but the last, shorter one


def shards(trials: int, of: int) -> list[ShardDone]:
    out = []
    for number in range(1, of + 1):
        with pytest.raises(ShardDone) as done:
            vcmm.uncertainty(scenario(), trials=trials, sharing=Sharing(share=Share(number, of)))
        out.append(done.value)
    return out


@pytest.mark.parametrize("of", [1, 2, 8])
def test_shards_put_together_give_the_same(whole, of):
    parts = shards(TRIALS, of)
    assert len({p.key for p in parts}) == 1
    blocks = {b: t for p in parts for b, t in p.blocks.items()}
    found = vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(store=Shards(parts[0].key, blocks)))
    assert same(found, whole)


def test_shards_that_lack_or_differ(whole):
    first, second = shards(TRIALS, 2)
    with pytest.raises(DataError, match="no shard holds the block from 8192 on"):
        vcmm.uncertainty(scenario(), trials=TRIALS, sharing=Sharing(store=Shards(first.key, first.blocks)))
    with pytest.raises(DataError, match="of another job"):
        vcmm.uncertainty(
            scenario(), trials=TRIALS, seed=5, sharing=Sharing(store=Shards(first.key, second.blocks))
        )


def test_exact_trials_are_shared_too():
    alone = vcmm.uncertainty(scenario(), trials=1200, engine="exact")
    crew = Counting()
    assert same(vcmm.uncertainty(scenario(), trials=1200, engine="exact", sharing=Sharing(crew)), alone)
    assert crew.items == [(1000, 200), (500, 500), (0, 500)]
