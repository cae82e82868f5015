"""The text of a program file, and which dialect it seems to be written in."""

from __future__ import annotations

import re
from pathlib import Path

from vcmm.core.errors import DataError
from vcmm.core.text import raw_bytes
from vcmm.nc.dialects import EXTENSIONS, FRONT_ENDS


def read_bytes(path: Path) -> str:
    """The text of a program, line ends as they are. UTF-8, else Latin-1 (comments of old posts). Raises DataError."""
    raw = raw_bytes(path)
    if b"\0" in raw:
        line = raw.count(b"\n", 0, raw.index(b"\0")) + 1
        column = raw.index(b"\0") - (raw.rfind(b"\n", 0, raw.index(b"\0")) + 1) + 1
        raise DataError(
            f"{path}:{line}:{column}: a NUL byte stands here: this is no text; remove it or name the NC program"
        )
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


_SIGNS: tuple[tuple[str, str, str], ...] = (  # dialect, pattern (upper case, comments removed), what it is
    ("heidenhain", r"^\s*\d*\s*BEGIN PGM", "BEGIN PGM"),
    ("sinumerik", r"^\s*(?:N\d+\s*)?(?:DEF (?:REAL|INT)|TRANS|ATRANS|MSG\(|CYCLE\d+|G0?[23].*CR=|R\d+=|WORKPIECE)", "a Sinumerik word"),
    ("linuxcnc", r"^\s*(?:N\d+\s*)?O\s*(?:<|\d+\s*(?:SUB|CALL|IF|WHILE|DO|REPEAT))", "O-words"),
    ("linuxcnc", r"#<\w+>", "named parameters"),
    ("linuxcnc", r"\bG(?:64\s*P|59\.[123]|43\.1|92\.[123]|33\.1|41\.1|42\.1|90\.1|91\.1|38\.[2345])", "a code of LinuxCNC"),
    ("fanuc", r"^\s*(?:N\d+\s*)?(?:IF\s*\[|WHILE\s*\[|GOTO\s*\d)|G65\s*P|G66\s*P", "macro B"),
    ("fanuc", r"M98\s*P|M99\b|G54\.1\s*P|G5\.1\s*Q1|G0?5\.1\s*Q", "a code of Fanuc controls"),
    ("fanuc", r"G28[^\n]*G91|G91[^\n]*G28", "G28 and G91 in one block"),
    ("fanuc", r"^\s*%?\s*[:O]\d{4}", "a four-digit program number"),
)  # fmt: skip


def guess(text: str, path: Path | None) -> tuple[str, str]:
    """The dialect that a program seems to be written in, and why; the reason says when it is not sure."""
    suffix = path.suffix.lstrip(".").lower() if path else ""
    named = EXTENSIONS.get(suffix)
    if named == "linuxcnc":
        return named, f"the file ends in .{suffix}"
    if named in FRONT_ENDS:
        return str(named), f"the file ends in .{suffix}"
    plain = re.sub(r"\([^)\n]*\)|;[^\n]*", "", text[:200_000]).upper()
    signs = [(d, why) for d, pattern, why in _SIGNS if re.search(pattern, plain, re.MULTILINE)]
    if named is not None:
        return named, f"the file ends in .{suffix}"
    if signs:
        others = sorted({d for d, _ in signs} - {signs[0][0]})
        doubt = f"; signs of {', '.join(others)} are there too, so name it with --dialect" if others else ""
        return signs[0][0], f"the program has {signs[0][1]}{doubt}"
    if not re.search(r"Y[-+ \d.]", plain) and re.search(r"G0?[23][^\n]*K[-+ \d.]", plain):
        return "fanuc-lathe", "there is no Y and arcs have K, so name it with --dialect where that is wrong"
    return "fanuc", "nothing tells it apart, so name it with --dialect where that is wrong"
