"""Instruments: simulated readings of machines with sampled errors, joined to recordings, and written as files."""

from __future__ import annotations

from vcmm.files.own.recording_writer import recording_texts
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laying import join_layouts, layout, rows, simulate_reading
from vcmm.task.instruments.tracker import LASER_TRACER, lengths_to

__all__ = [
    "LASER_TRACER",
    "InstrumentCertificate",
    "join_layouts",
    "layout",
    "lengths_to",
    "recording_texts",
    "rows",
    "simulate_reading",
]
