"""--workers, --shard and merge as a user types them: the same document to the last byte."""

from __future__ import annotations

import json

import pytest

from tests.hostile.judge import ask, inside
from tests.plate import PLATE
from tests.shop.machining import shop
from vcmm.answer.evaluation import sampling
from vcmm.show.console.documents import fingerprint

TRIALS = "20000"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("shards")
    (out / "plate.toml").write_text(PLATE)
    with pytest.MonkeyPatch.context() as patch, inside(out):
        patch.setenv("XDG_CACHE_HOME", str(out / "cache"))
        patch.setattr(sampling, "WORK_BLOCK", 8192)
        for i in (1, 2):
            answer = ask(("uncertainty", "plate.toml", "--trials", TRIALS, "--shard", f"{i}/2"))
            assert (answer.code, answer.err) == (0, f"wrote plate.shard-{i}-of-2.json\n")
        whole = ask(("uncertainty", "plate.toml", "--trials", TRIALS, "--json"))
        (out / "whole.json").write_text(whole.out)
        yield out


FILES = ("plate.shard-1-of-2.json", "plate.shard-2-of-2.json")


def merged(*words: str):
    return ask(("merge", *words))


@pytest.mark.thorough
def test_merged_shards_are_the_document_of_one_process(folder):
    answer = merged(FILES[1], FILES[0], "--json")
    assert answer.code == 0, answer.err
    assert answer.out == (folder / "whole.json").read_text()


@pytest.mark.thorough
def test_two_workers_give_the_document_of_one(folder):
    answer = ask(("uncertainty", "plate.toml", "--trials", TRIALS, "--workers", "2", "--json"))
    assert answer.out == (folder / "whole.json").read_text()
    assert not list((folder / "cache").rglob("*.json"))


@pytest.mark.thorough
def test_merge_writes_the_files_of_the_job(folder):
    assert merged(*FILES, "--out", "merged").code == 0
    assert {p.name for p in (folder / "merged").iterdir()} == {
        "report.html",
        "uncertainty.json",
        "budget.csv",
    }


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ((), "merge needs the files of all shards"),
        (FILES[:1], "shard 2 of 2 is missing"),
        ((*FILES, FILES[0]), "shard 1 is there twice"),
        (("plate.toml",), "plate.toml:1: no JSON document"),
        (("whole.json",), "whole.json:1: no shard"),
    ],
)
def test_what_merge_refuses(folder, files, words):
    answer = merged(*files)
    assert answer.code == 2
    assert words in answer.err


@pytest.mark.parametrize(
    "change", [{"blocks": None}, {"blocks": []}, {"shard": "a"}, {"key": 5}, {"verb": "rm"}], ids=str
)
def test_a_shard_that_was_changed_is_refused(folder, change):
    one = json.loads((folder / FILES[1]).read_text()) | change
    (folder / "changed.json").write_text(json.dumps(one))
    answer = merged(FILES[0], "changed.json")
    assert answer.code == 2
    assert "changed.json:1: this shard is not as it was written (SHA-256 differs)" in answer.err


def test_a_shard_of_another_job_is_refused(folder):
    other = json.loads((folder / FILES[1]).read_text())
    other["options"]["trials"] = 30000
    other["sha256"] = fingerprint(other)
    (folder / "other.json").write_text(json.dumps(other))
    answer = merged(FILES[0], "other.json")
    assert answer.code == 2
    assert "other.json:1: a shard of another job" in answer.err
    assert "(options differ)" in answer.err


def test_files_that_changed_since_are_refused(folder):
    text = (folder / "plate.toml").read_text()
    (folder / "plate.toml").write_text(text.replace('"3 urad"', '"4 urad"'))
    answer = merged(*FILES)
    (folder / "plate.toml").write_text(text)
    assert answer.code == 2
    assert "plate.toml:1: the file has changed since the shards were made" in answer.err


@pytest.mark.parametrize("shard", ["0/2", "3/2", "2", "a/b", "1/0", "٣/٣"])
def test_shards_that_do_not_exist(folder, shard):
    answer = ask(("uncertainty", "plate.toml", "--shard", shard))
    assert answer.code == 2
    assert "shard" in answer.err


def test_adaptive_trials_cannot_be_split(folder):
    answer = ask(("uncertainty", "plate.toml", "--digits", "2", "--shard", "1/2"))
    assert answer.code == 2
    assert "--digits decides on the way" in answer.err


@pytest.mark.thorough
def test_a_cut_is_shared_as_well(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    shop.write(tmp_path, '[repeatability]\nu = "1 um"\n')
    with inside(tmp_path):
        whole = ask(("cut", "boss.toml", "--json"))
        parts = [ask(("cut", "boss.toml", "--json", "--shard", f"{i}/2")).out for i in (1, 2)]
        for i, text in enumerate(parts):
            (tmp_path / f"{i}.json").write_text(text)
        answer = ask(("merge", "0.json", "1.json", "--json"))
    assert answer.out == whole.out
