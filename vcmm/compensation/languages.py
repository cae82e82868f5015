"""Tables by dialect: its numbers, its writer, its comments."""

from __future__ import annotations

from vcmm.compensation.writer import Writer
from vcmm.program.dialects import G_CODE, Dialect

SINUMERIK = Dialect("sinumerik", "sinumerik", {"G70": 25.4, "G71": 1.0, "G700": 25.4, "G710": 1.0})
KLARTEXT = Dialect("heidenhain", "klartext", {})
LANGUAGES: dict[str, Dialect] = {**G_CODE, "sinumerik": SINUMERIK, "heidenhain": KLARTEXT}


def writer_of(dialect: Dialect) -> type[Writer]:
    """Return the class that writes the blocks of a dialect."""
    if dialect.name == "sinumerik":
        from vcmm.compensation.sinumerik_writer import SinumerikWriter

        return SinumerikWriter
    if dialect.name == "heidenhain":
        from vcmm.compensation.klartext_writer import KlartextWriter

        return KlartextWriter
    return Writer
