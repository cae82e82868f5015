"""What must be refused, with the line, and never guessed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, lathe, mill, rough, run, scale
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.face.cli import run as vcmm

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
    assert run(tmp_path, text, mill()).blocks.changes == 0


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
    from vcmm.program import dialects

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
    assert vcmm(files(tmp_path, machine, setup)) == 0  # unstated: 20 degC, and it is said
    assert "taken as 20 degC" in capsys.readouterr().err
    assert "G1 X100. F500" in (tmp_path / "new.nc").read_text()
    assert vcmm(files(tmp_path, machine, setup + '[temperature]\nscale_x = "22 degC"\n')) == 0
    assert "G1 X99.998 F500" in (tmp_path / "new.nc").read_text()


def test_a_path_wound_about_a_turning_axis(tmp_path):
    text = "%\nO1\nG21 G90 G54 (NOT G12.1 HERE)\nG1 X100. F500\nG12.1\nG1 X40. C10.\nG13.1\nM30\n%\n"
    assert "part.nc:5:1: G12.1 winds the path" in refused(tmp_path, text)


def test_polar_words_are_refused_where_they_begin(tmp_path):
    """G16: X is a radius there; a number in mm beside the workpiece's X would send the tool 29 mm aside."""
    text = "O1\nG21 G90 G17 G54\nT1 M6\nG0 X0 Y0 Z20.\n{} G81 X30. Y45. Z-5. R2. F100.\nG15 G80\nM30\n"
    assert "part.nc:5:1: G16 makes X and Y" in refused(tmp_path, text.format("G16"), scale(100.0))
    assert run(tmp_path, text.format("(G16)"), scale(100.0)).is_met


def test_polar_words_in_a_file_that_is_called(tmp_path):
    (tmp_path / "O2.nc").write_text("O2\nG16 G1 X30. Y45. F200\nG15\nM99\n")
    text = "O1\nG21 G90 G17 G54\nT1 M6\nG0 X0 Y0 Z20.\nM98 P2\nM30\n"
    assert "O2.nc:2:1: G16 makes X and Y" in refused(tmp_path, text, scale(100.0))


@pytest.mark.parametrize(
    ("dialect", "block", "word"),
    [("sinumerik", "G1 AP=30 RP=50 F200", "AP"), ("linuxcnc", "G1 @50 ^45 F200", "@")],
)
def test_polar_words_of_one_block_are_refused(tmp_path, dialect, block, word):
    text = f"G90 G17 G54\nG0 X100 Y0 Z0\n{block}\nM2\n"
    message = refused(tmp_path, text, scale(100.0), replace(SETUP, dialect=dialect))
    assert f"part.nc:3:4: the polar word {word} is not rewritten" in message


LATHE_HEAD = "O1\nG21 G18 G40 G99\nT0101\nG97 S1000 M3\nG0 X42. Z2.\n"
CONTOUR = "N100 G0 X20.\nG1 Z-20. F0.1\nG2 X30. Z-25. R5.\nN200 G1 X42.\n"


@pytest.mark.parametrize(
    ("cycle", "line", "code"),
    [
        ("G71 U2. R0.5\nG71 P100 Q200 U0.4 W0.1 F0.3\n" + CONTOUR + "G70 P100 Q200\n", 7, "G71"),
        ("G72 W2. R0.5\nG72 P100 Q200 U0.4 W0.1 F0.3\n" + CONTOUR, 7, "G72"),
        ("G70 P100 Q200\n" + CONTOUR, 6, "G70"),
        ("G74 R1.\nG74 Z-20. Q5000 F0.1\n", 7, "G74"),
        ("G75 R1.\nG75 X20. P5000 F0.1\n", 7, "G75"),
        ("G76 P010060 Q100 R0.05\nG76 X38. Z-20. P900 Q300 F1.5\n", 7, "G76"),
        ("G90 X38. Z-20. F0.2\nX36.\n", 6, "G90"),
        ("G92 X39. Z-20. F1.5\n", 6, "G92"),
        ("G94 X30. Z-2. F0.1\n", 6, "G94"),
    ],
    ids=["G71 G70", "G72", "G70", "G74", "G75", "G76", "G90", "G92", "G94"],
)
def test_turning_cycles_are_refused_with_their_line(tmp_path, cycle, line, code):
    text = f"{LATHE_HEAD}{cycle}G0 X200. Z100.\nM30\n"
    message = refused(tmp_path, text, lathe(), replace(SETUP, dialect="fanuc-lathe"))
    assert f"part.nc:{line}:1: the cycle {code} is not rewritten" in message


def test_a_program_that_would_get_worse_is_not_written(tmp_path, monkeypatch):
    """A fault of ours: a correction twice as large as the error, the other way. 10 um become 20 um; nothing stands on the disk."""
    from vcmm.compensation import rewriting

    def wrong(*given, **more):
        fits = real(*given, **more)
        return [
            replace(f, pieces=tuple(replace(p, end=p.end - [0.02, 0, 0]) for p in f.pieces)) for f in fits
        ]

    real = rewriting.targets
    monkeypatch.setattr(rewriting, "targets", wrong)
    message = refused(tmp_path, PROGRAM, scale(100.0), error=ModelLimit)
    assert (
        "worse than the original: 20.00 um off at line 4, where the original is off by no more than 10.00 um"
        in message
    )


def test_a_program_of_another_control_than_that_of_the_setup(tmp_path):
    message = refused(
        tmp_path, "O1005\nG21 G90 G54\nG91 G1 X10. F100\nM30\n", setup=replace(SETUP, dialect="sinumerik")
    )
    assert "was read as sinumerik, that of the set-up; it looks like fanuc" in message
    assert "perhaps --dialect fanuc" in message


def test_a_stock_removal_cycle_is_refused_by_its_line(tmp_path):
    text = 'G18 G90 G95 G54\nT1 D1\nS800 M4\nG0 X60 Z2\nCYCLE95("ANF:ENDE",2,0,0,0,0.2,0.1,0.1,9,,,1)\nM30\nANF:\nG1 X20 Z0\nZ-20\nX40\nENDE:\n'
    message = refused(tmp_path, text, scale(100.0), setup=replace(SETUP, dialect="sinumerik"))
    assert "part.nc:5" in message
    assert "the cycle CYCLE95 is not rewritten" in message


def test_a_swivel_with_the_name_of_its_head_is_compensated(tmp_path):
    """CYCLE800(..., "TC1", ...) by A = 0: X at 100 mm is cut 10 um too long on this machine."""
    text = 'G17 G90 G54\nT1 D1\nCYCLE800(1,"TC1",0,57,0,0,0,0,0,0,0,0,0,-1,100,1)\nG0 X0 Y0 Z20\nG1 X100 F200\nM30\n'
    found = run(tmp_path, text, scale(100.0), replace(SETUP, dialect="sinumerik"))
    assert 'CYCLE800(1,"TC1",0,57' in found.text
    assert "X99.990" in found.text


def test_what_only_a_lathe_with_more_than_one_tool_carrier_has(tmp_path):
    """Blocks of driven tools at C, another spindle, a file of two channels, TRANSMIT: each by its line."""
    head = "%\nO1\nG21 G98 F100.\nG54 T0101 S500 M3\nG0 X50. Z2.\n"
    setup = replace(
        SETUP,
        dialect="fanuc-lathe",
        offsets={**SETUP.offsets, "G55": (0.0, 0.0, 0.0)},
        work_spindles={"G55": 2},
    )
    for block, what in (
        ("G1 X40. C30.\n", "part.nc:6:1: axis C of a lathe is off zero"),
        ("G55\nG1 X40.\n", "part.nc:7:1: the part in spindle 2 is cut here"),
        ("$2\nG1 X40.\n", "part.nc:6:1: a channel begins here; a file of several channels is not rewritten"),
    ):
        error = DataError if "$" in block else ModelLimit
        message = refused(
            tmp_path,
            head + block + "M30\n%\n",
            lathe("w C' b Z X t"),
            setup,
            error=error,
            dialect="fanuc-lathe",
        )
        assert what in message
    text = "G90 G71 DIAMON G54\nT1 D1\nS500 M3\nG0 X50 Z2\nTRANSMIT\nG1 X40 Y10 F100\nTRAFOOF\nM30\n"
    message = refused(
        tmp_path,
        text,
        lathe("w C' b Z X t"),
        replace(setup, dialect="sinumerik"),
        error=ModelLimit,
        dialect="sinumerik",
    )
    assert "part.nc:6:1: X and C lead the tip over the end face" in message
