"""The one runner: order of its steps, what it writes, exit codes."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from vcmm.core.errors import UsageError
from vcmm.face.job import Flags, Job, Progress, Record, run_job, share_of


@dataclass(frozen=True)
class SquareJob(Job[int, int]):
    """The square of a number."""

    number: int
    refused: bool = False
    steps: list[str] = field(default_factory=list)
    schema = "vcmm.square/1"

    def load(self) -> int:
        self.steps.append("load")
        return self.number

    def run(self, loaded: int, report: Progress) -> int:
        self.steps.append("run")
        return loaded**2

    def record(self, loaded: int, result: int) -> Record:
        return Record({"square": result}, [], seed=3)

    def texts(self, loaded: int, result: int, content: str, folder: Path) -> dict[str, str]:
        return {"square.json": content, "square.txt": str(result)}

    def exit_code(self, loaded: int, result: int) -> int:
        if self.refused:
            raise UsageError("nothing is decided")
        return int(result > 10)

    def show(self, loaded: int, result: int) -> None:
        print(f"square {result}")


def test_words_or_one_document(capsys: pytest.CaptureFixture[str]):
    assert run_job(SquareJob(3), Flags()) == 0
    assert capsys.readouterr().out == "square 9\n"
    assert run_job(SquareJob(4), Flags(json=True)) == 1  # 16 > 10
    document = json.loads(capsys.readouterr().out)
    assert (document["schema"], document["square"], document["seed"]) == ("vcmm.square/1", 16, 3)


def test_files_of_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    run_job(SquareJob(3), Flags(out=tmp_path / "new"))
    assert json.loads((tmp_path / "new" / "square.json").read_text())["square"] == 9
    assert (tmp_path / "new" / "square.txt").read_text() == "9"
    assert capsys.readouterr().err == f"wrote {tmp_path / 'new'}/square.json, square.txt\n"


def test_a_refusal_leaves_nothing_behind(tmp_path: Path):
    job = SquareJob(3, refused=True)
    with pytest.raises(UsageError, match="nothing is decided"):
        run_job(job, Flags(out=tmp_path / "new"))
    assert job.steps == ["load", "run"]
    assert not (tmp_path / "new").exists()


def test_a_place_that_cannot_be_written_is_refused_before_any_work(tmp_path: Path):
    (tmp_path / "file").write_text("")
    job = SquareJob(3)
    with pytest.raises(Exception, match="cannot be written"):
        run_job(job, Flags(out=tmp_path / "file" / "new"))
    assert job.steps == []


def test_shares():
    share = share_of("2/8")
    assert share is not None
    assert (share.number, share.of) == (2, 8)
    with pytest.raises(UsageError, match="--shard"):
        share_of("2 of 8")


class LateJob(SquareJob):
    """Says its files behind the answer, and ends with a fault that was put off."""

    names_files_last = True

    def notes(self, loaded: int, result: int) -> list[str]:
        return ["note: small"]

    def finish(self, loaded: int, result: int) -> None:
        self.steps.append("finish")
        raise RuntimeError("put off")


def test_what_is_said_last_and_what_is_put_off(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Files and answer are there before the fault is raised."""
    job = LateJob(3)
    with pytest.raises(RuntimeError, match="put off"):
        run_job(job, Flags(out=tmp_path))
    told = capsys.readouterr()
    assert told.out == "square 9\n"
    assert told.err == f"note: small\nwrote {tmp_path}/square.json, square.txt\n"
    assert (tmp_path / "square.json").is_file()
    assert job.steps == ["load", "run", "finish"]
