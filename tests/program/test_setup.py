"""Tools of a set-up."""

from __future__ import annotations

from vcmm.program.interpret import interpret
from vcmm.program.setup import FANUC_TIPS, LINUXCNC_TIPS, Setup, Tool, turns_with


def test_radius_and_offset_of_a_tool():
    assert Tool(1).radius is None
    assert Tool(1, diameter=10.0).radius == 5.0
    assert Tool(1, diameter=10.0, shape="turning", nose_radius=0.8).radius == 0.8
    assert Tool(1, length=80.0, offset_x=-3.0).offset == (-3.0, 0.0, 80.0)


def test_tips_of_the_two_conventions_are_mirrored_in_x():
    # Fanuc 3 is the usual outside turning tool, -X -Z of its centre; LinuxCNC calls the same one 2
    assert FANUC_TIPS[3] == LINUXCNC_TIPS[2] == (-1, -1)
    assert {t: (-x, z) for t, (x, z) in FANUC_TIPS.items()} == LINUXCNC_TIPS


def test_only_tools_that_cut_count_as_turning():
    tools = {1: Tool(1, shape="turning"), 2: Tool(2)}
    for number, turns in ((1, True), (2, False)):
        program = interpret(f"G21\nT{number} M6\nG1 X1. F100.\nM30", "fanuc", Setup(tools=tools))
        assert turns_with(Setup(tools=tools), program) is turns
