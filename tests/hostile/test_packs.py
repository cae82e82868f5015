"""Hostile evidence packs against `vcmm rerun`: nothing outside the pack is read, run or told to exist, no bug shows, no "same" that is none.

`python -m tests.hostile.test_packs` prints the count.
"""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

from tests.hostile.bench_corpus import CANARY, SECRETS
from tests.hostile.pack_corpus import Pack, cases
from tests.plate import PLATE
from vcmm.face.cli import run

OPENED: list[str] = []
sys.addaudithook(
    lambda event, a: OPENED.append(str(a[0])) if event in ("open", "os.listdir", "os.scandir") else None
)


def honest(folder: Path) -> bytes:
    """An honest pack of the plate, its machine in another folder than its scenario."""
    for name in ("machines", "jobs"):
        (folder / name).mkdir()
    head, rest = PLATE.split("[machine]\n", 1)
    machine, part = rest.split("[part]\n", 1)
    (folder / "machines" / "m.toml").write_text('vcmm = "machine/1"\n' + machine.replace("machine.", ""))
    scenario = folder / "jobs" / "plate.toml"
    scenario.write_text(head + 'machine = "../machines/m.toml"\n[part]\n' + part)
    (folder / "values.csv").write_text("characteristic,deviation_um\nbore diameter,10\n")
    words = ["--values", str(folder / "values.csv"), "--trials", "2000", "--seed", "3"]
    made = folder / "pack.zip"
    assert run(["evaluate", str(scenario), *words, "--evidence", str(made), "--json"]) == 0
    return made.read_bytes()


@pytest.fixture(scope="module")
def archive(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    return honest(tmp_path_factory.mktemp("honest"))


def judge(one: Pack, folder: Path, outside: Path, capfd: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code and words. Fails where something outside was opened, or something was painted."""
    file = folder / "pack.zip"
    file.write_bytes(one.archive)
    capfd.readouterr()
    OPENED.clear()
    code = run(["rerun", str(file)])
    touched = [o for o in OPENED if os.path.realpath(o).startswith(str(outside))]
    out, err = capfd.readouterr()
    assert touched == [], one.name
    assert code in one.codes, (one.name, code, out, err)
    assert not (code == 2 and out), one.name
    assert "Traceback" not in out + err, one.name
    assert "\x1b" not in out + err, (one.name, "paints the terminal")
    assert CANARY not in out + err, one.name
    assert "root:" not in out + err, one.name
    assert (code == 0) == ("is the same" in out and "not the same" not in out), (one.name, out)
    return code, out, re.sub(r"\S*/tmp[^/ ]*/(?=files|pack)", "", err)


@pytest.mark.thorough
def test_every_hostile_pack_is_refused_or_told(
    archive: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    outside, folder = tmp_path / "outside", tmp_path / "given"
    outside.mkdir()
    folder.mkdir()
    without = {}
    for one in cases(archive, outside):
        said = judge(one, folder, outside, capfd)
        if one.outside:
            assert one.name not in without
            without[one.name] = said
        assert sorted(p.name for p in folder.iterdir()) == ["pack.zip"], one.name
        assert list(outside.iterdir()) == [], one.name
    for name, text in (SECRETS | {"values.csv": "characteristic,deviation_um\nbore diameter,10\n"}).items():
        (outside / name).write_text(text)
    (outside / "plate.toml").write_text(PLATE)
    for one in cases(archive, outside):
        if one.outside:
            assert judge(one, folder, outside, capfd) == without[one.name], one.name


def test_the_honest_pack_is_the_same(
    archive: bytes, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    one = Pack("honest", archive, codes=(0,))
    assert "to the last bit" in judge(one, tmp_path, tmp_path / "none", capfd)[1]


if __name__ == "__main__":
    import contextlib
    import io
    import tempfile

    with tempfile.TemporaryDirectory() as place, contextlib.redirect_stdout(io.StringIO()):
        every = list(cases(honest(Path(place)), Path("/x")))
    print(
        f"{len(every)} packs, {sum(p.outside for p in every)} of which name a file outside: each with it and without it"
    )
