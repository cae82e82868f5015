"""Files come into being whole or not at all; a set of them all or none."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from vcmm.core.errors import Environment
from vcmm.core.whole_files import write_files

NEW = {"a.csv": "new a", "b.html": "new b", "c.json": "new c"}


def contents(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in sorted(folder.iterdir()) if p.is_file()}


def test_a_set_is_written_and_nothing_else_stays(tmp_path):
    (tmp_path / "b.html").write_text("old b")
    assert write_files(tmp_path, NEW) == [tmp_path / name for name in NEW]
    assert contents(tmp_path) == NEW


@pytest.mark.parametrize("at", range(len(NEW)))
@pytest.mark.parametrize("links", [True, False], ids=["second names", "copies"])
def test_one_rename_that_fails_brings_all_files_back(tmp_path, monkeypatch, at, links):
    old = {"a.csv": "old a", "c.json": "old c"}
    for name, text in old.items():
        (tmp_path / name).write_text(text)
    real, calls = Path.replace, []

    def fails(self, target):
        calls.append(target)
        if len(calls) == at + 1:
            raise OSError(5, "Input/output error")
        return real(self, target)

    def no_links(*names):
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(Path, "replace", fails)
    if not links:
        monkeypatch.setattr(os, "link", no_links)
    with pytest.raises(Environment, match="Input/output error"):
        write_files(tmp_path, NEW)
    assert contents(tmp_path) == old


def test_an_interrupt_between_two_renames_brings_all_files_back(tmp_path, monkeypatch):
    (tmp_path / "a.csv").write_text("old a")
    real = Path.replace

    def interrupted(self, target):
        if Path(target).name == "b.html":
            raise KeyboardInterrupt
        return real(self, target)

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files(tmp_path, NEW)
    assert contents(tmp_path) == {"a.csv": "old a"}


KILLED = """
import os, signal, sys
from pathlib import Path
from vcmm.core.whole_files import write_files
count, at = [0], int(sys.argv[2])
def counted(real):
    def step(*args, **more):
        count[0] += 1
        if count[0] == at:
            os.kill(os.getpid(), signal.SIGKILL)
        return real(*args, **more)
    return step
for owner, name in ((Path, "write_text"), (Path, "replace"), (Path, "unlink"), (os, "link")):
    setattr(owner, name, counted(getattr(owner, name)))
write_files(Path(sys.argv[1]), {"a.csv": "new" * 1000, "b.html": "new" * 1000})
"""


def test_killed_at_every_write_leaves_no_half_of_a_file(tmp_path):
    ends = []
    for at in range(1, 12):
        folder = tmp_path / str(at)
        folder.mkdir()
        for name in ("a.csv", "b.html"):
            (folder / name).write_text("old")
        done = subprocess.run([sys.executable, "-c", KILLED, str(folder), str(at)], check=False)
        ends.append(done.returncode)
        assert {(folder / name).read_text() for name in ("a.csv", "b.html")} <= {"old", "new" * 1000}
    assert ends[0] == -9
    assert ends[-1] == 0  # all steps were met


def test_two_writers_of_one_set_do_not_mix(tmp_path):
    def write(word: str) -> None:
        for _ in range(50):
            write_files(tmp_path, {"a.csv": word * 10_000})

    threads = [threading.Thread(target=write, args=(word,)) for word in "xy"]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert contents(tmp_path) in ({"a.csv": "x" * 10_000}, {"a.csv": "y" * 10_000})


def test_a_full_disk_leaves_the_old_files(tmp_path):
    disk = tmp_path / "disk"
    disk.mkdir()
    if (
        os.geteuid() != 0
        or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", str(disk)], check=False, capture_output=True
        ).returncode
    ):
        pytest.skip("a small disk needs root and mount")
    try:
        (disk / "a.csv").write_text("old")
        with pytest.raises(Environment, match="No space left"):
            write_files(disk, {"a.csv": "new", "b.html": "x" * 200_000})
        assert contents(disk) == {"a.csv": "old"}
    finally:
        subprocess.run(["umount", str(disk)], check=False)
