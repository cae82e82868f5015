"""Registers the languages that are no members of the G-code family. They are imported when the first program is read."""

from __future__ import annotations

from vcmm.nc.dialects import register
from vcmm.nc.moves import Program
from vcmm.nc.setup import Setup


def sinumerik(text: str, name: str, setup: Setup) -> Program:
    """A Sinumerik program (vcmm.nc.sinumerik.read)."""
    from vcmm.nc.sinumerik import read

    return read(text, name, setup)


def sinumerik_traced(text: str, name: str, setup: Setup) -> Program:
    """The same with traces."""
    from vcmm.nc.sinumerik import read

    return read(text, name, setup, trace=True)


def heidenhain(text: str, name: str, setup: Setup) -> Program:
    """A HEIDENHAIN Klartext program (vcmm.nc.heidenhain.read)."""
    from vcmm.nc.heidenhain import read

    return read(text, name, setup)


def heidenhain_traced(text: str, name: str, setup: Setup) -> Program:
    """The same with traces."""
    from vcmm.nc.heidenhain import read

    return read(text, name, setup, trace=True)


register("sinumerik", sinumerik, ("mpf", "spf"), sinumerik_traced)
register("heidenhain", heidenhain, ("h",), heidenhain_traced)
