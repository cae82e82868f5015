"""Programs of two channels in one file: $1, $2 on lines of their own (Fanuc and its kin on lathes with two turrets or spindles).

One channel is read, the others are blanked line by line, so that numbers of lines stay. Lines before the first mark belong to all channels, without a mark $1 to channel 1.
Codes on which channels wait for each other move nothing; how long one waits is not known and not counted.
"""

from __future__ import annotations

import re

from vcmm.core.errors import UsageError
from vcmm.program.iso.control import IsoControl
from vcmm.program.moves import Remark

_MARK = re.compile(r"[ \t]*\$([1-9])[ \t]*(?:\([^()]*\)[ \t]*)?\r?\n?\Z")


def marks_of(text: str) -> dict[int, int]:
    """Return the line -> channel that begins there."""
    marks = (
        (k, _MARK.match(line)) for k, line in enumerate(text.splitlines(keepends=True), 1) if "$" in line
    )
    return {k: int(m[1]) for k, m in marks if m}


def one_channel(text: str, marks: dict[int, int], wanted: int) -> str:
    """Return the text with all other channels and the marks themselves blanked."""
    out, now = [], 0 if 1 in marks.values() else 1
    for k, line in enumerate(text.splitlines(keepends=True), 1):
        now = marks.get(k, now)
        stays = k not in marks and now in (0, wanted)
        out.append(line if stays else line[len(line.rstrip("\r\n")) :])
    return "".join(out)


def tell_other_channels(c: IsoControl, marks: dict[int, int]) -> None:
    """Note the unread part of a program of several channels, by line. Raises UsageError: the set-up asks for a channel that does not exist."""
    channel = c.setup.channel
    if channel not in {1, *marks.values()}:
        raise UsageError(
            f"{c.file}: the program has the channels {', '.join(map(str, sorted(set(marks.values()))))}, not {channel}; correct channel in the set-up"
        )
    for line, number in marks.items():
        if number != channel:
            text = f"channel {number} begins here and is left out; channel {channel} is read. channel = {number} in the set-up reads this one, on its own"
            c.remarks.append(Remark(line, 1, text))
