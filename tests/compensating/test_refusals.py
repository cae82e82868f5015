"""What must be refused, with the line, and never guessed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensating.mill import SETUP, mill, rough, run, scale
from vcmm.cli import run as vcmm
from vcmm.core.errors import DataError, ModelLimit, UsageError

PROGRAM = "%\nO1\nG21 G90 G54\nG1 X100. F500\nM30\n%\n"
MACHINE = """vcmm = "machine/1"
kind = "machine-tool"
structure = "w X' Y' b Z t"
[axes.X]
travel = ["-200 mm", "200 mm"]
[axes.Y]
travel = ["-200 mm", "200 mm"]
[axes.Z]
travel = ["-200 mm", "200 mm"]
"""
EFFECT = '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "100 um/m"\n'
SET = 'vcmm = "setup/1"\nmachine = "m.toml"\ndialect = "fanuc"\n[offsets]\nG54 = ["0 mm", "0 mm", "0 mm"]\n'


def refused(tmp_path, text, machine=None, setup=SETUP, error=DataError, **more) -> str:
    with pytest.raises(error) as found:
        run(tmp_path, text, machine or rough(), setup, **more)
    return str(found.value)


def test_our_own_mark(tmp_path):
    done = run(tmp_path, PROGRAM, scale(100.0)).text
    message = refused(tmp_path, done)
    assert "part.nc:3:2" in message
    assert "compensated already" in message


def test_an_offset_that_is_not_in_the_setup(tmp_path):
    message = refused(tmp_path, PROGRAM.replace("G54", "G57"))
    assert "part.nc:4" in message
    assert "G57" in message


def test_a_tool_that_is_not_in_the_setup(tmp_path):
    message = refused(tmp_path, PROGRAM.replace("G54", "G54 T7 M6"), setup=replace(SETUP, tools={}))
    assert "part.nc:4" in message
    assert "[tools.7]" in message


@pytest.mark.parametrize(
    "text",
    [
        "%\nO1\nG21 G90 G54\nM98 P2 L2\nM30\nO2\nG1 X100. F500\nG0 X0\nM99\n%\n",
        "%\nO1\nG21 G90 G54\n#1=0\nWHILE[#1 LT 3]DO1\nG1 X[10*#1] F500\n#1=#1+1\nEND1\nM30\n%\n",
    ],
    ids=["subprogram", "loop"],
)
def test_blocks_that_are_executed_several_times(tmp_path, text):
    assert "executed" in refused(tmp_path, text, inline=0)


def test_a_subprogram_called_once_is_rewritten(tmp_path):
    text = "%\nO1\nG21 G90 G54\nM98 P2\nM30\nO2\nG1 X100. F500\nM99\n%\n"
    assert "G1 X99.990 F500" in run(tmp_path, text, scale(100.0)).text


def test_a_loop_on_a_perfect_machine_is_no_problem(tmp_path):
    text = "%\nO1\nG21 G90 G54\n#1=0\nWHILE[#1 LT 3]DO1\nG1 X[10*#1] F500\n#1=#1+1\nEND1\nM30\n%\n"
    assert run(tmp_path, text, mill()).blocks.changed == 0


def test_frames_that_depend_on_where_the_tool_stands(tmp_path):
    text = "%\nO1\nG21 G90 G54\nG1 X100. F500\nG92 X0\nG1 X10.\nM30\n%\n"
    assert "G92" in refused(tmp_path, text, scale(100.0), error=ModelLimit)


def test_travel_after_correction(tmp_path):
    # -100 um/m: 100 mm become 100.010 mm, beyond a travel of 100.005 mm
    message = refused(
        tmp_path, PROGRAM, replace(scale(-100.0), axes=mill(travel=100.005).axes), error=ModelLimit
    )
    assert "part.nc:4" in message
    assert "after correction" in message
    message = refused(
        tmp_path, PROGRAM, replace(scale(-100.0), axes=mill(travel=99.0).axes), error=ModelLimit
    )
    assert "already as programmed" in message


def test_dialects_without_traces(tmp_path, monkeypatch):
    from vcmm.nc import dialects

    monkeypatch.setitem(dialects.FRONT_ENDS, "other", dialects.FRONT_ENDS["sinumerik"])
    message = refused(tmp_path, PROGRAM, setup=replace(SETUP, dialect="other"), error=UsageError)
    assert "other" in message
    assert "--offset-only" in message


def test_rotary_axes_and_increments_of_turning(tmp_path):
    from vcmm.core.kinematics import Axis, parse_structure

    turning = replace(
        mill(*rough().effects), chain=parse_structure("w C' X' Y' b Z t"),
        axes={**mill().axes, "C": Axis("C", (-10.0, 10.0))},
    )  # fmt: skip
    text = PROGRAM.replace("X100.", "X100. C30.")
    assert "rotary" in refused(tmp_path, text, turning, error=ModelLimit)


def test_tolerance_must_be_positive(tmp_path):
    assert "tolerance" in refused(tmp_path, PROGRAM, error=UsageError, tolerance=0.0)


# -- the state of the control ------------------------------------------------------------------------------------------
def files(folder, machine: str = MACHINE + EFFECT, setup: str = SET, table: str = "") -> list[str]:
    (folder / "p.nc").write_text(PROGRAM)
    (folder / "m.toml").write_text(machine)
    (folder / "s.toml").write_text(setup)
    (folder / "e.csv").write_text(table or "X EXX\n-200 -0.02\n200 0.02\n")
    return [
        "compensate",
        str(folder / "p.nc"),
        "--setup",
        str(folder / "s.toml"),
        "--out",
        str(folder / "new.nc"),
    ]


ERRORS = '[errors]\ntable = "e.csv"\n'


@pytest.mark.parametrize(
    ("machine", "setup", "said"),
    [
        (MACHINE + EFFECT, SET, "compensation = []"),
        (MACHINE + ERRORS, SET + "[control]\ncompensation = []\n", "state"),
        (MACHINE + ERRORS + 'state = "residual"\ncompensation = ["pitch"]\n', SET + "[control]\ncompensation = []\n", "pitch"),
        (MACHINE + ERRORS + 'state = "raw"\n', SET + '[control]\ncompensation = ["pitch"]\n', "pitch"),
        (MACHINE + EFFECT, SET + '[control]\ncompensation = "pitch"\n', "list"),
        (MACHINE + EFFECT, SET.replace('machine = "m.toml"\n', "") + "[control]\ncompensation = []\n", "names no machine"),
    ],
)  # fmt: skip
def test_state_of_the_control(tmp_path, capsys, machine, setup, said):
    assert vcmm(files(tmp_path, machine, setup)) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert not (tmp_path / "new.nc").exists()


def test_the_same_state_is_accepted(tmp_path):
    machine = MACHINE + ERRORS + 'state = "residual"\ncompensation = ["Pitch"]\n'
    words = files(tmp_path, machine, SET + '[control]\ncompensation = ["pitch"]\n')
    assert vcmm(words) == 0
    # the table holds +100 um/m of the table's own motion: it goes 10 um too far to -X, the tip stands at 99.990 of the part
    assert "G1 X100.010 F500" in (tmp_path / "new.nc").read_text()


def test_a_setup_must_be_named(tmp_path, capsys):
    files(tmp_path)
    assert vcmm(["compensate", str(tmp_path / "p.nc")]) == 2
    assert "--setup" in capsys.readouterr().err


def test_the_program_itself_is_never_overwritten(tmp_path, capsys):
    words = files(tmp_path, setup=SET + "[control]\ncompensation = []\n")
    assert vcmm([*words[:-1], str(tmp_path / "p.nc")]) == 2
    assert (tmp_path / "p.nc").read_text() == PROGRAM


def test_temperatures_of_the_setup(tmp_path, capsys):
    """A scale of 10 um/(m K) at 22 degC makes 100 mm 2 um longer."""
    machine = MACHINE + '[[effects]]\neffect = "scale_expansion"\naxis = "X"\nalpha = "10 um/(m K)"\n'
    setup = SET + "[control]\ncompensation = []\n"
    assert vcmm(files(tmp_path, machine, setup)) == 2
    assert "temp_scale" in capsys.readouterr().err
    assert vcmm(files(tmp_path, machine, setup + '[temperature]\nscale_x = "22 degC"\n')) == 0
    assert "G1 X99.998 F500" in (tmp_path / "new.nc").read_text()


def test_a_path_wound_about_a_turning_axis(tmp_path):
    text = "%\nO1\nG21 G90 G54 (NOT G12.1 HERE)\nG1 X100. F500\nG12.1\nG1 X40. C10.\nG13.1\nM30\n%\n"
    assert "part.nc:5:1: G12.1 winds the path" in refused(tmp_path, text)
