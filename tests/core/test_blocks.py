"""Blocks of a job: kept, taken up again, shared; every item once, results in their order."""

from __future__ import annotations

import pytest

from vcmm.core.blocks import Folder, ShardDone, Shards, Share, Sharing, blocks_of, key_of
from vcmm.core.errors import DataError, UsageError


def squared(asked, item):
    asked.append(item)
    if item == 13:
        raise KeyboardInterrupt
    return {"square": item * item}


SQUARES = [{"square": n * n} for n in (3, 4, 5)]


def test_blocks_of_a_job():
    assert blocks_of(20, 8) == [(0, 8), (8, 8), (16, 4)]
    assert blocks_of(3, 8) == [(0, 3)]
    assert Share(2, 2).take(blocks_of(20, 8)) == [(8, 8)]
    with pytest.raises(UsageError, match="write 1/3 to 3/3"):
        Share(4, 3)


def test_results_stand_in_the_order_of_their_items_and_progress_reaches_one():
    def backwards(work, payload, items):
        for i in reversed(range(len(items))):
            yield i, work(payload, items[i])

    seen: list[float] = []
    assert Sharing(backwards).map_items("", squared, [], [3, 4, 5], seen.append) == SQUARES
    assert seen == pytest.approx([1 / 3, 2 / 3, 1])


def test_what_was_finished_is_not_done_again(tmp_path):
    sharing, first, again = Sharing(store=Folder(tmp_path)), [], []
    with pytest.raises(KeyboardInterrupt) as stopped:
        sharing.map_items("job", squared, first, [3, 4, 13])
    assert stopped.value.__notes__ == ["what is finished is kept: the same call goes on where it was"]
    assert {p.name for p in (tmp_path / "job").iterdir()} == {"0-1.json", "1-1.json"}
    assert sharing.map_items("job", squared, again, [3, 4, 5]) == SQUARES
    assert again == [5]
    assert not (tmp_path / "job").exists()


def test_shards_hold_every_block_once_and_are_put_together():
    parts = []
    for k in (1, 2):
        with pytest.raises(ShardDone) as done:
            Sharing(share=Share(k, 2)).map_items("job", squared, [], [3, 4, 5])
        parts.append(done.value.blocks)
    assert [sorted(p) for p in parts] == [[(0, 1), (2, 1)], [(1, 1)]]
    untouched: list[int] = []
    merged = Sharing(store=Shards("job", parts[0] | parts[1]))
    assert merged.map_items("job", squared, untouched, [3, 4, 5]) == SQUARES
    assert untouched == []
    with pytest.raises(DataError, match="no shard holds the block from 1 on"):
        Sharing(store=Shards("job", parts[0])).map_items("job", squared, [], [3, 4, 5])


def test_a_job_is_known_by_all_that_it_reads(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text("one")
    keys = {
        key_of("audit", {"seed": 1}, [file]),
        key_of("place", {"seed": 1}, [file]),
        key_of("audit", {"seed": 2}, [file]),
    }
    assert key_of("audit", {"seed": 1}, [file, file]) in keys  # a file that is named twice is read once
    file.write_text("two")
    keys.add(key_of("audit", {"seed": 1}, [file]))
    assert len(keys) == 4
