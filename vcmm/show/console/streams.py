"""Write to stdout and stderr of terminals with few letters."""

from __future__ import annotations

import codecs
import sys

PLAIN = {
    "µ": "u", "μ": "u", "°": "deg", "±": "+/-", "×": "x", "·": "*", "–": "-", "−": "-", "—": "-", "…": "...", "²": "^2", "³": "^3",
    "≤": "<=", "≥": ">=", "≈": "~", "√": "sqrt", "Δ": "d", "σ": "sigma", "ν": "nu", "α": "alpha", "χ": "chi", "→": "->",
    "Ø": "D", "⌀": "D", "″": '"', "′": "'", "“": '"', "”": '"', "’": "'", "∞": "inf",
}  # fmt: skip


def writes_utf8() -> bool:
    """Return whether stdout can write every letter."""
    return (
        str(getattr(sys.stdout, "encoding", "utf-8") or "utf-8").lower().replace("_", "-").startswith("utf")
    )


def in_plain_letters() -> None:
    """Make stdout and stderr write um for µm and \\u.... for letters without a plain form, where they cannot write them."""
    codecs.register_error("vcmm.plain", _plain)
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="vcmm.plain")


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    words = (PLAIN.get(c, ascii(c)[1:-1]) for c in error.object[error.start : error.end])
    return "".join(words), error.end
