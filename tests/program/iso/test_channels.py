"""Two channels in one file, two spindles in one program: one is read, the other told by line."""

from __future__ import annotations

import pytest

from vcmm.core.errors import UsageError
from vcmm.program.interpret import interpret
from vcmm.program.iso.channels import marks_of, one_channel
from vcmm.program.setup import Setup, Tool

TWO = (
    "%\nO1\nG21\n$1\nG0 X50. Z2.\nM100\nG1 Z-5. F0.1\n$2 (LOWER TURRET)\nG0 X20. Z9.\nM100\nG1 X10. F0.2\n%\n"
)
SPINDLES = "%\nO1\nG21 G98 F100.\nG54\nG0 X50. Z2.\nG1 Z-5.\nG55\nG0 X20. Z9.\nG1 X10.\nG54\nG0 X60.\n%\n"


def test_lines_keep_their_numbers():
    text = one_channel(TWO, marks_of(TWO), 2)
    assert text.count("\n") == TWO.count("\n")
    assert [k for k, line in enumerate(text.splitlines(), 1) if line] == [1, 2, 3, 9, 10, 11, 12]
    assert marks_of("$$\n$H\nG1 X$1\n") == {}


@pytest.mark.parametrize(("channel", "lines"), [(1, [5, 7]), (2, [9, 11])])
def test_one_channel_is_read_and_the_other_told(channel, lines):
    program = interpret(TWO, "fanuc-lathe", Setup(strict=False, channel=channel))
    assert [m.source.line for m in program.moves] == lines
    told = [(w.line, w.text) for w in program.warnings if "channel" in w.text]
    assert [line for line, _ in told] == [8 if channel == 1 else 4]
    assert told[0][1].startswith(
        f"channel {3 - channel} begins here and is left out; channel {channel} is read"
    )


def test_a_channel_that_is_not_there():
    with pytest.raises(UsageError, match="has the channels 1, 2, not 3"):
        interpret(TWO, "fanuc-lathe", Setup(strict=False, channel=3))


def test_what_stands_before_the_first_mark_without_a_mark_of_its_own():
    program = interpret(TWO.replace("$1\n", "\n"), "fanuc-lathe", Setup(strict=False))
    assert [m.source.line for m in program.moves] == [5, 7]


def test_moves_carry_the_spindle_of_their_work_offset():
    program = interpret(SPINDLES, "fanuc-lathe", Setup(strict=False, work_spindles={"G55": 2}))
    assert [(m.source.line, m.work_spindle) for m in program.moves] == [
        (5, 1),
        (6, 1),
        (8, 2),
        (9, 2),
        (11, 1),
    ]
    told = [(w.line, w.text) for w in program.warnings if "spindle" in w.text]
    assert told[0] == (
        7,
        "from here on the part in spindle 2 is cut; what was cut before is that of spindle 1",
    )
    assert told[1][0] == 10


def test_the_sub_spindle_of_haas_and_okuma():
    haas = interpret(
        SPINDLES.replace("G55", "G14").replace("G54\nG0 X60", "G15\nG0 X60"),
        "haas-lathe",
        Setup(strict=False),
    )
    assert [m.work_spindle for m in haas.moves] == [1, 1, 2, 2, 1]
    okuma = interpret("G140\nG0 X50 Z2\nG141\nG0 X20\nM02\n", "okuma", Setup(strict=False))
    assert [m.work_spindle for m in okuma.moves] == [1, 2]


def test_codes_of_the_builder_move_nothing_where_tools_are_driven():
    setup = Setup(strict=True, tools={2: Tool(2, shape="drill", diameter=6.0, driven="x")})
    program = interpret(
        "%\nO1\nG21 G98\nT0202\nM23\nM133 P1000\nG0 X50. C30.\nM30\n%\n", "fanuc-lathe", setup
    )
    assert any(
        "M133 belongs to the machine builder; it is taken to move nothing" in w.text for w in program.warnings
    )
