"""The set-up file with blanks."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.files.own.blank_setup import blank_setup
from vcmm.files.own.setup import load_setup
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

TEXT = "G21 F100.\nT2 M6\nG55 G0 X10. Y0\nG3 X0 Y10. I0 J0\nG41 D2 G1 X-10.\nG40 X-20.\nT4 M6\nG1 X0\nM30\n"


def test_it_loads_once_its_blanks_are_filled(tmp_path: Path):
    text = blank_setup(interpret(TEXT, "fanuc", Setup(strict=False)), "part.nc")
    path = tmp_path / "set-up.toml"
    path.write_text(text.replace('"?"', '"6 mm"'))
    setup = load_setup(path)
    assert (setup.dialect, setup.arc_centre) == ("fanuc", "absolute")
    assert (set(setup.tools), setup.tools[2].diameter, setup.tools[4].diameter) == ({2, 4}, 6.0, None)
    assert setup.offsets == {"G55": (0.0, 0.0, 0.0)}
    assert interpret(TEXT, None, setup).moves[1].centre == (
        0.0,
        0.0,
        0.0,
    )  # strict now: nothing is left to assume
    assert text.count('"?"') == 2  # the remark at the head, and the diameter of tool 2


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("heidenhain", '0 BEGIN PGM A MM\n1 TOOL CALL "MILL_D10" Z S3000 F500\n2 L X+10 Y+0 R0\n3 END PGM A MM\n'),
        ("sinumerik", 'G71 T="MILL_D10"\nM6\nG1 X10 F100\nM30\n'),
    ],
)  # fmt: skip
def test_tools_called_by_name_have_it_and_a_blank_length(dialect: str, text: str, tmp_path: Path):
    blank = blank_setup(interpret(text, dialect, Setup(strict=False)), "part.h")
    path = tmp_path / "set-up.toml"
    path.write_text(blank)
    with pytest.raises(DataError, match=r'length = "\?" has no number; write for example length = "80 mm"'):
        load_setup(path)
    path.write_text(blank.replace('"?"', '"70 mm"'))
    setup = load_setup(path)
    assert [(t.name, t.length) for t in setup.tools.values()] == [("MILL_D10", 70.0)]
    program = interpret(text, dialect, setup)
    assert program.moves[-1].tool_offset == (0.0, 0.0, 70.0)


def test_the_example_of_a_refused_blank_is_that_of_its_line(tmp_path: Path):
    text = "G21 G90\nT3 M6\nG43 H3 Z50.\nG41 D3 G1 X10. F100.\nY5.\nG40 X0.\nM30\n"
    blank = blank_setup(interpret(text, "fanuc", Setup(strict=False)), "part.nc")
    path = tmp_path / "set-up.toml"
    path.write_text(blank)
    with pytest.raises(DataError) as caught:
        load_setup(path)
    wanted = [line for line in blank.splitlines() if " for example " in line]
    assert len(wanted) == len(caught.value.problems) == 2
    for line, said in zip(wanted, caught.value.problems, strict=True):
        assert line.split("for example ")[1] in said  # "80 mm", "10 mm"
