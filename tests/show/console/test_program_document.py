"""The document of a program, written move by move."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup
from vcmm.program.summary import summary
from vcmm.show.console.program_document import MoveFile, json_job, move_text
from vcmm.show.tables.program import move_json

TEXT = (
    "%\nO1\nG21 G90 G17 F100.5\nT1 M6\nS500 M3\nG0 X1. Y2. Z3.\nG1 X0.5\nG41 D1 Y5.\nG3 X-4.5 Y10. I-5. J0\nG40 G1 X-9.\nG4 P500\n"
    "G0 A90.\nM30\n%"
)


def test_a_move_reads_back_as_the_table_has_it():
    moves = interpret(TEXT, "fanuc", Setup(strict=False)).moves
    assert {m.kind for m in moves} == {"rapid", "line", "arc", "dwell"}
    assert [json.loads(move_text(m)) for m in moves] == [move_json(m) for m in moves]


def test_moves_that_come_in_pieces_are_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    path = tmp_path / "part.nc"
    lines = "".join(f"X{i}. Y{i % 7}.\n" for i in range(200))
    path.write_text(TEXT.replace("G4 P500\n", f"G1\n{lines}G2 X0. Y0. R500.\n{lines}"))
    whole = interpret(path.read_text(), "fanuc", Setup(strict=False), str(path))
    monkeypatch.setattr("vcmm.program.moves.MoveFlow.CHUNK", 50)
    assert json_job(path, "fanuc", Setup(strict=False)) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["schema"] == "vcmm.nc/1"
    assert document["moves"] == [move_json(m) for m in whole.moves]
    expected = summary(whole.moves).as_json()
    assert document["summary"]["moves"] == expected["moves"]
    assert document["summary"]["extent_machine_mm"] == expected["extent_machine_mm"]
    assert document["summary"]["cutting_time_s"] == pytest.approx(expected["cutting_time_s"], rel=1e-12)
    assert [a["what"] for a in document["assumed"]] == [a.what for a in whole.assumed]


def test_nothing_is_printed_of_a_program_that_breaks_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
):
    from vcmm.face.cli import run

    path = tmp_path / "part.nc"
    path.write_text("%\nO1\nG21 G0\n" + "".join(f"X{i}.\n" for i in range(200)) + "G1 F100. X..5\nM30\n")
    monkeypatch.setattr("vcmm.program.moves.MoveFlow.CHUNK", 50)
    assert run(["nc", str(path), "--json"]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert f"{path}:204:" in shown.err


def test_a_second_reading_starts_anew():
    moves = interpret(TEXT, "fanuc", Setup(strict=False)).moves
    with MoveFile(None) as file:
        file.take(moves)
        file.restart()
        file.take(moves[:2])
        file.file.seek(0)
        assert len(json.loads(f"[{file.file.read()}]")) == 2 == file.builder.total().counts["rapid"] + 1


def test_a_led_move_keeps_its_tool_axis_also_where_no_rotary_axis_turns():
    """G43.5: the direction is in the block, the angles are those of a machine that is not known; a machine without A has no A."""
    text = "G21 G90\nT1 M6\nG43.5 H1 G0 Z10.\nG1 X1. I0 J0 K1. F100\nX2. I3. J0 K4.\nM30\n"
    last = interpret(text, "fanuc", Setup(strict=False)).moves[-1]
    written = json.loads(move_text(last, "XYZBC"))
    assert written["tool_axis_start"] == [0.0, 0.0, 1.0]
    assert written["tool_axis_end"] == [0.6, 0.0, 0.8]
    assert written["led"]
    assert written["rotary_start_rad"] == {"B": 0.0, "C": 0.0}
    assert written["rotary_end_rad"] is None
