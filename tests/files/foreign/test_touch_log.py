"""Logs of touches as controls print them."""

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files.foreign.touch_log import read_touch_log


def read(tmp_path, text):
    path = tmp_path / "touch.log"
    path.write_text(text)
    return read_touch_log(path)


def test_lines_of_four_controls_read_the_same(tmp_path):
    fanuc = "TOUCH F1 I-1 J0 K0 X  137.5041 Y20. Z-5. A-30. C60."
    sinumerik = "TOUCH F1 I-1 J0 K0 X137.5041 Y20. Z-5. A-30. C60."
    heidenhain = "TOUCH F1 I-1 J 0 K 0 X   137.5041 Y    20.0000 Z    -5.0000 A   -30.0000 C    60.0000"
    dprnt = "touch F 1 I -1 J 0 K 0 X + 137.5041 Y 20.0000 Z - 5.0000 A - 30. C60."
    found = read(tmp_path, "%\n" + "\n".join([fanuc, sinumerik, heidenhain, dprnt]) + "\n\n(end)\n%\n")
    assert list(found.features) == ["1"] * 4
    for letter, value in {"X": 137.5041, "Y": 20, "Z": -5, "A": -30, "C": 60, "I": -1}.items():
        assert found.values[letter] == pytest.approx([value] * 4)
    assert list(found.lines) == [2, 3, 4, 5]
    assert isinstance(found.values["S"], np.ndarray)
    assert not found.values["S"].any()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("TOUCH F1 X1 Y2\n", "1: Z missing"),
        ("TOUCH F1 X1 Y2 Z3 Q4\n", "1: Q is no word of a touch"),
        ("TOUCH F1 X1 X2 Y2 Z3\n", "1: X is given twice"),
        ("TOUCH F1 I1 J1 K0 X1 Y2 Z3\n", r"1: I J K = 1 1 0 has the length 1.414"),
        ("TOUCH F1.5 X1 Y2 Z3\n", "F1.5 is no number of a feature"),
        ("ALARM 92\n", "1: .*neither a touch"),
        ("TOUCH F1 X1 Y2 Z3 A10\nTOUCH F1 X1 Y2 Z3\n", "2: A is missing, which other lines state"),
        ("TOUCH F1 X1,5 Y2 Z3\n", "is no letter with a number"),
        ("(nothing)\n", "no line begins with TOUCH"),
    ],
)
def test_what_is_no_touch_is_refused_with_its_line(tmp_path, text, said):
    with pytest.raises(DataError, match=said):
        read(tmp_path, text)
