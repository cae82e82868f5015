"""Evidence packs: a result run again from its pack gives the same numbers, and a changed pack is told."""

from __future__ import annotations

import contextlib
import hashlib
import json
import tempfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.plate import PLATE
from vcmm.answer.evaluation.declaration import KNOWN, NOT_COVERED, UNCERTAIN, declared_influences
from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.evidence import ComparedNumber, differences, unpack_evidence


@pytest.fixture
def pack(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Path:
    """Of a job whose machine lies in another folder than its scenario and its values."""
    (tmp_path / "machines").mkdir()
    (tmp_path / "jobs").mkdir()
    head, rest = PLATE.split("[machine]\n", 1)
    machine, part = rest.split("[part]\n", 1)
    (tmp_path / "machines" / "m.toml").write_text('vcmm = "machine/1"\n' + machine.replace("machine.", ""))
    scenario = tmp_path / "jobs" / "plate.toml"
    scenario.write_text(head + 'machine = "../machines/m.toml"\n[part]\n' + part)
    (tmp_path / "values.csv").write_text("characteristic,deviation_um\nbore diameter,10\n")
    made = tmp_path / "pack.zip"
    words = ["--values", str(tmp_path / "values.csv"), "--trials", "2000", "--seed", "3"]
    assert run(["evaluate", str(scenario), *words, "--evidence", str(made), "--json"]) == 0
    capsys.readouterr()
    return made


def changed(pack: Path, name: str, edit: Callable[[str], str], rename: str = "") -> Path:
    """A copy of the pack with one file edited."""
    copy = pack.with_name("changed.zip")
    with zipfile.ZipFile(pack) as old, zipfile.ZipFile(copy, "w") as new:
        for one in old.namelist():
            text = old.read(one).decode()
            new.writestr(rename or one if one == name else one, edit(text) if one == name else text)
    return copy


def test_a_pack_runs_again_to_the_last_bit(pack: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for one in pack.parent.rglob("*.toml"):
        one.unlink()  # everything that is needed is in the pack
    assert run(["rerun", str(pack), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["same"], found["identical"], found["differences"]) == (True, True, [])
    with zipfile.ZipFile(pack) as held:
        names, said = held.namelist(), json.loads(held.read("evidence.json"))
    assert {"files/jobs/plate.toml", "files/machines/m.toml", "files/values.csv"} <= set(names)
    assert (said["schema"], said["seed"], len(said["files"])) == ("vcmm.evidence/1", 3, 3)
    assert said["command"][:2] == ["evaluate", "files/jobs/plate.toml"]


def test_a_number_that_was_changed_is_found(pack: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = changed(
        pack, "document.json", lambda text: text.replace('"measured_mm": 30.01', '"measured_mm": 30.02')
    )
    assert run(["rerun", str(other)]) == 1
    assert "characteristics[0].measured_mm: 30.02 then, 30.01 now" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "edit", "rename", "message"),
    [
        ("files/values.csv", ("10", "11"), "", "files/values.csv was changed after the pack was made"),
        ("files/values.csv", ("", ""), "files/other.csv", "files/values.csv is listed and missing"),
        ("files/values.csv", ("", ""), "../values.csv", "lies outside the pack"),
        ("evidence.json", ("evaluate", "new"), "", "no job that --evidence writes"),
        ("evidence.json", ('"--trials"', '"--out"'), "", "no job that --evidence writes"),
        ("evidence.json", ("vcmm.evidence/1", "vcmm.evidence/9"), "", "this version reads vcmm.evidence/1"),
        ("document.json", ("{", ""), "", "document.json is no JSON"),
        ("document.json", ("{", "[" * 100_000), "", "document.json is no JSON"),
        ("evidence.json", ('"libraries"', '"other"'), "", "evidence.json lacks libraries"),
        ("evidence.json", ('"status"', '"other"'), "", "lists influences without name and status"),
    ],
)  # fmt: skip
def test_packs_that_are_not_to_be_trusted(
    pack: Path,
    capsys: pytest.CaptureFixture[str],
    name: str,
    edit: tuple[str, str],
    rename: str,
    message: str,
) -> None:
    other = changed(pack, name, lambda text: text.replace(*edit, 1), rename)
    assert run(["rerun", str(other)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_no_pack_at_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "x.zip").write_text("no zip")
    assert run(["rerun", str(tmp_path / "x.zip")]) == 2
    assert "this is no evidence pack" in capsys.readouterr().err


def test_differences_by_hand() -> None:
    was = {"version": "1", "a": [1.0, {"b": 2.0}], "c": None}
    assert list(differences(was, {"version": "2", "a": [1.0, {"b": 2.0}], "c": None})) == []
    (one,) = differences(was, {"a": [1.0, {"b": 2.5}], "c": None})
    assert (one.key, one.relative) == ("a[1].b", pytest.approx(0.2))
    assert ComparedNumber("x", True, False).relative == float("inf")
    assert [d.key for d in differences(was, {"a": [1.0], "c": 0})] == ["a", "c"]


def test_what_the_plate_covers() -> None:
    found = {i.influence: i for i in declared_influences(load_scenario(example("plate")).task())}
    assert found["squareness"].status == UNCERTAIN
    assert found["squareness"].inputs == ("squareness[C0Y].angle",)
    assert found["component"].status == KNOWN  # straightness stated without an uncertainty
    assert found["backlash"].status == NOT_COVERED
    assert "channel.temp_part_C" in found["temperatures"].inputs
    assert found["form of the part"].status == NOT_COVERED
    assert "setting" not in found  # of machine tools only


OUTSIDE = 'machine = "../machines/m.toml"'


@pytest.mark.parametrize("exists", [True, False])
@pytest.mark.parametrize("how", ["absolute", "climbing", "table", "values", "scenario"])
def test_a_pack_is_run_on_its_own_files_alone(
    pack: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], how: str, exists: bool
) -> None:
    """A machine, values or a scenario outside are not read, quoted or told to exist; the listed SHA-256 are those of the spoilt files."""
    outside = tmp_path / "secret"
    outside.mkdir()
    target = outside / ("m.toml" if how != "values" else "v.csv")
    if exists:
        with zipfile.ZipFile(pack) as held:
            target.write_bytes(held.read("files/machines/m.toml" if how != "values" else "files/values.csv"))
    with zipfile.ZipFile(pack) as held:
        data = {n: held.read(n).decode() for n in held.namelist()}
    said = json.loads(data["evidence.json"])
    if how in ("absolute", "climbing", "table"):
        name = str(target) if how == "absolute" else "../" * 12 + str(target).lstrip("/")
        new = f'machine = "{name}"' if how != "table" else f'machine = """\n{target}"""'
        data["files/jobs/plate.toml"] = data["files/jobs/plate.toml"].replace(OUTSIDE, new)
    elif how == "values":
        said["command"][said["command"].index("--values") + 1] = str(target)
    else:
        said["command"][1] = str(target)
    for one in said["files"]:
        one["sha256"] = hashlib.sha256(data[one["file"]].encode()).hexdigest()
    data["evidence.json"] = json.dumps(said)
    spoilt = tmp_path / "spoilt.zip"
    with zipfile.ZipFile(spoilt, "w") as new_pack:
        for n, text in data.items():
            new_pack.writestr(n, text)
    assert run(["rerun", str(spoilt)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert "outside the given files" in err
    assert "does not exist" not in err


def test_a_flipped_bit_is_no_bug(pack: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Every 97th byte of the archive in turn: refused, or the same numbers where the byte means nothing."""
    whole = pack.read_bytes()
    copy = pack.with_name("flipped.zip")
    for at in range(0, len(whole), 97):
        copy.write_bytes(whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
        with contextlib.suppress(DataError), tempfile.TemporaryDirectory() as folder:
            unpack_evidence(copy, Path(folder))


@pytest.mark.parametrize("value", ["null", "3", '["a"]', '[{"file": 3, "sha256": "x"}]', "[" * 100_000])
def test_lists_of_files_that_are_none(pack: Path, capsys: pytest.CaptureFixture[str], value: str) -> None:
    other = changed(
        pack, "evidence.json", lambda text: '{"schema": "vcmm.evidence/1", "files": ' + value + "}"
    )
    assert run(["rerun", str(other)]) == 2
    assert "evidence.json" in capsys.readouterr().err


def test_same_is_not_said_beside_what_is_no_number() -> None:
    """A change of 1e-9 (the same on another computer) hid a NaN behind it; true is not 1, and 10^400 is no float."""
    was, found = {"a": 1.0, "b": 2.0}, {"a": 1.0 + 1e-9, "b": float("nan")}
    assert max(d.relative for d in differences(was, found)) == float("inf")
    assert max(d.relative for d in differences(was, {"a": 1.0, "b": float("inf")})) == float("inf")
    assert [d.relative for d in differences({"a": 1}, {"a": True})] == [float("inf")]
    assert [d.relative for d in differences({"a": 1}, {"a": 10**400})] == [float("inf")]


def test_the_cost_is_told_before_it_is_paid(pack: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = changed(pack, "evidence.json", lambda text: text.replace('"2000"', '"99999999999"'))
    assert run(["rerun", str(other)]) == 2
    assert "99,999,999,999 trials" in capsys.readouterr().err
    assert run(["rerun", str(pack), "--most-trials", "1000"]) == 2
    assert "2,000 trials" in capsys.readouterr().err
