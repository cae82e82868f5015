"""Notices beside a result: their severity, subject, and what to do.

Sentences of the package have one grammar: `where: what is so; what to do`. A note says how something was computed or taken;
a warning, that the result may be worse than it looks; an error, that a part of it is missing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

Severity = Literal["note", "warning", "error"]
NOTES = (
    "assumed", "computed by", "grows with noise", "is stated with", "used an approximation", "left to the control", "guessed", "the known bias of",
    "not in it", "for comparison", "written out", "passed over", "Drawn are",
)  # fmt: skip
ERRORS = (
    "failed",
    "could not be",
    "was not computed",
    "has no pictures",
    "were not diagnosed",
    " is nan",
    " is inf",
    " is -inf",
)
_CURE = re.compile(
    r"[;:,] ((?:add|correct|check|turn|touch|use|name|give|state|write|choose|measure|repeat|record|log|look|compare|leave|take|set|calibrate|reduce|raise|"
    r"increase|qualify|fit|read|remove|declare|confirm)\b.*)$"
)
_WHERE = re.compile(r'^("[^"]+"|[^:;.]{1,60}(?::\d+(?::\d+)?)?): ')


@dataclass(frozen=True)
class Notice:
    """One sentence with its severity, place and cure."""

    severity: Severity
    where: str
    text: str
    cure: str

    def document(self) -> dict[str, str]:
        return {"severity": self.severity, "where": self.where, "text": self.text, "cure": self.cure}


def notice(text: str) -> Notice:
    """Parse a sentence; where and cure are empty where it names none."""
    place, cure = _WHERE.match(text), _CURE.search(text)
    return Notice(
        _severity(text),
        place[1].strip('"')
        if place and not place[1].lower().startswith(("note", "warning", "assumed"))
        else "",
        text,
        cure[1].rstrip(".") if cure else "",
    )


def _severity(text: str) -> Severity:
    if any(word in text for word in ERRORS):
        return "error"
    return "note" if any(word in text for word in NOTES) else "warning"


def in_terminal(text: str) -> str:
    """Return a sentence with its severity in front, as one line for stderr: "note: ..."."""
    return f"{notice(text).severity}: {text}"


def documents(texts: Iterable[str]) -> list[dict[str, str]]:
    return [notice(text).document() for text in texts]
