"""Numbers of thousands of digits and tapes of blank lines: refused with their place, or read in time."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.core.text import raw_bytes
from vcmm.program.interpret import read_program
from vcmm.program.recognition import SIGNS

DIGITS = "3" * 5000


@pytest.mark.parametrize(
    ("name", "text", "place"),
    [
        ("a.nc", f"O{DIGITS}\nG1 X1 F100\nM30\n", "1:2"),
        ("a.mpf", f"G90\nR{DIGITS}=3\nG1 X1 F100\nM30\n", "2:2"),
        ("a.h", f"BEGIN PGM A MM\nTOOL CALL {DIGITS} Z S100\nEND PGM A MM\n", "2:11"),
        ("b.h", f"BEGIN PGM A MM\nLBL 1\nL X+1 F100\nCALL LBL 1 REP {DIGITS}\nEND PGM A MM\n", "4:16"),
        ("a.ngc", f"o{DIGITS} sub\nG1 X1 F100\nM2\n", "1:2"),
        ("a.min", f"G15 H{DIGITS}\nM02\n", "1:6"),
    ],
)
def test_a_number_of_thousands_of_digits_is_refused(tmp_path: Path, name: str, text: str, place: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(DataError, match=f":{place}: a number of 5,000 digits") as refused:
        read_program(path)
    assert len(str(refused.value)) < 300 + len(str(path))


def test_signs_of_dialects_do_not_run_over_lines() -> None:
    """`^\\s*` goes on over blank lines, once from each of them: 10^6 lines took the square of their number."""
    for sign in SIGNS:
        assert not sign.pattern.startswith(r"^\s"), sign


def test_a_small_file_asks_for_little_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """read(n) of Python asks the system for n bytes before it reads one: a limit of address space (containers) refused it."""
    asked: list[int] = []
    path = tmp_path / "a.txt"
    path.write_bytes(b"0123456789")

    class Spy:
        def __init__(self, *_: object) -> None:
            self.file = open(path, "rb")  # noqa: SIM115 - closed by __exit__

        def __enter__(self) -> Spy:
            return self

        def __exit__(self, *_: object) -> None:
            self.file.close()

        def read(self, n: int) -> bytes:
            asked.append(n)
            return self.file.read(n)

    monkeypatch.setattr(Path, "open", Spy)
    assert raw_bytes(path) == b"0123456789"
    assert raw_bytes(path, 3) == b"012"
    assert max(asked) <= 1 << 20
