"""Describe a line of a budget in words of the trade: its cause, and what reduces it. The declaration of the effect holds the words."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.core.declaration import Trade
    from vcmm.core.effect import Effect

_PLACE = re.compile(r"\[([^\]]*)\]")
BY_REDRAW = {  # what helps where an effect says nothing of its own
    "touch": "more points on the feature, or the mean of repeated measurements",
    "event": "index the head less often, or qualify after every indexing",
    "pass": "a machine that repeats better, or a spring pass",
    "setup": "measure the set-up again, or take the mean over several set-ups",
    "stylus": "qualify the stylus again, with more touches",
    "tool": "measure the tool again",
    "pose": "measure in more than one pose and take the mean",
    "part": "measure more than one part",
}
ROOM_TEMPERATURE = (
    "temperature of the room",
    "a steadier room, longer soaking, or thermometers on part and scales",
)
CALIBRATE = "calibrate the machine for it, or move the part where it shows less (vcmm place)"


def contributor(line: Any) -> str:
    """Return the operator's name of a BudgetLine: "repeatability of the probe", "temperature of the part"."""
    if line.redraw == "pass":
        return "repeatability of the machine from pass to pass"
    if line.input.startswith("environment.room"):
        return ROOM_TEMPERATURE[0]
    trade = _trade(line)
    if trade is not None and trade.name:
        return _fill_in_place(trade.name, line) + _cause(line)
    words = str(line.what).split("; `")[0]
    if _is_temperature(line):
        place = words.removesuffix(", true minus reading").removeprefix("temperature ")
        return f"temperature of the {_speak(place)}"
    head, colon, rest = words.partition(": ")
    return f"{rest} ({head})" if colon else words


def what_to_change(line: Any) -> str:
    """Return what reduces this line, in one clause."""
    if line.redraw == "pass":
        return BY_REDRAW["pass"]
    if line.input.startswith("environment.room"):
        return ROOM_TEMPERATURE[1]
    trade = _trade(line)
    if trade is not None and trade.change:
        return _fill_in_place(trade.change, line)
    if _is_temperature(line):
        return "longer soaking, or a better thermometer"
    if line.input.startswith("form["):
        return "more points on the feature, all over it"
    if line.redraw in BY_REDRAW:
        return BY_REDRAW[line.redraw]
    kind = _kind_of(line)
    if kind is not None and kind.about.words is not None:
        return f"know it better: {_fill_in_place(kind.about.words.confirm, line)}"
    return CALIBRATE


def _is_temperature(line: Any) -> bool:
    return bool(line.input.startswith("channel.temp_"))


def _effect(line: Any) -> str:
    return str(re.split(r"[\[.]", line.input)[0])


def _kind_of(line: Any) -> type[Effect] | None:
    """Return the effect of a line; the list of effects is loaded here, since documents without a budget need none."""
    from vcmm.physics import BY_NAME

    return BY_NAME.get(_effect(line))


def _trade(line: Any) -> Trade | None:
    kind = _kind_of(line)
    return None if kind is None else kind.about.trade


def _fill_in_place(words: str, line: Any) -> str:
    """Return the words with the place in them; without one its gap is closed."""
    return " ".join(words.format(where=_where(line)).split()).removesuffix(",")


def _where(line: Any) -> str:
    place = _PLACE.search(line.input)
    return "" if place is None or place[1] == "*" else place[1].replace(",", ", ")


def _cause(line: Any) -> str:
    """Return the cause of a line, where one input has several causes: ", sphere diameter"."""
    _, by, cause = str(line.what).rpartition(", by the ")
    return f", {cause}" if by else ""


def _speak(place: str) -> str:
    """scale x -> X scale."""
    word, _, axis = place.rpartition(" ")
    return f"{axis.upper()} {word}" if word and len(axis) == 1 else place
