"""Blocks counted by anybody, kept, taken up again, and put together from shards: always the result of one process."""

from __future__ import annotations

import json

import numpy as np
import pytest

import vcmm
from tests.build import scenario
from vcmm.answer.evaluation import sampling
from vcmm.answer.evaluation.summary import Accumulator
from vcmm.answer.evaluation.tallies import pack, unpack
from vcmm.core.blocks import Folder, ShardDone, Shards, Share, Sharing, blocks_of
from vcmm.core.errors import DataError

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
