"""The set-up file with blanks."""

from __future__ import annotations

from pathlib import Path

from vcmm.files.blank_setup import blank_setup
from vcmm.files.setup import load_setup
from vcmm.nc.interpret import interpret
from vcmm.nc.setup import Setup

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
