"""Read [instrument] of a recording file to the certificate of the instrument."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.core.units import parse_unit
from vcmm.files.own.recording_tables import InstrumentTable
from vcmm.files.problems import Problems, TableProblems
from vcmm.files.schema import checked_model
from vcmm.files.toml import read_toml
from vcmm.task.instruments import find
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

SENSORS = {"air": ("temp_air_C", "pressure_hPa"), "material": ("temp_part_C",)}


def load_certificate(path: str | Path, recording: Recording) -> InstrumentCertificate | None:
    """Return the instrument that a recording file names; None where it names none.

    Raises DataError with file and line: unknown instruments, errors that it does not have, units, a kind of recording that
    it does not make, sensors that a claimed compensation needs and the data lack.
    """
    document = read_toml(path)
    table = document.data.get("instrument")
    if table is None:
        return None
    problems = Problems(document)
    model = checked_model(InstrumentTable, table, problems, ("instrument",))
    certificate = None
    if model is not None:
        certificate = problems.attempt(("instrument",), lambda: _certificate(model, recording))
    problems.raise_if_any()
    return certificate


def instrument_text(certificate: InstrumentCertificate) -> str:
    """Return [instrument] as `load_certificate` reads it."""
    out = f'[instrument]\nname = "{certificate.instrument.name}"\n'
    out += f'serial = "{certificate.serial}"\n' if certificate.serial else ""
    stated = []
    for name, u in certificate.u.items():
        unit = certificate.instrument.error(name).unit
        stated.append(f'{name} = "{u / parse_unit(unit).factor:.10g} {unit}"')
    if stated:
        out += f"u = {{ {', '.join(stated)} }}\n"
    return out + (f'redraw = "{certificate.redraw}"\n' if certificate.redraw != "machine" else "")


def _certificate(table: InstrumentTable, recording: Recording) -> InstrumentCertificate:
    try:
        instrument = find(table.name)
    except UsageError as error:
        raise TableProblems([("name", str(error))]) from None
    if recording.kind not in instrument.kinds:
        kinds = " or ".join(f'"{k}"' for k in instrument.kinds)
        message = f'"{table.name}" makes recordings of kind {kinds}; this one is of kind "{recording.kind}"'
        raise TableProblems([("name", message)])
    missing = [(what, c) for what in table.compensated for c in SENSORS[what] if not _has(recording.run, c)]
    if missing:
        what, column = missing[0]
        raise TableProblems(
            [
                (
                    "compensated",
                    f"compensation of {what} is claimed, but the data have no {column}; add the column, or remove the claim",
                )
            ]
        )
    if table.redraw != "machine" and table.redraw not in recording.run.labels:
        raise TableProblems(
            [
                (
                    "redraw",
                    f'the data have no label column "{table.redraw}"; add it, or write redraw = "machine"',
                )
            ]
        )
    try:
        return InstrumentCertificate.of(instrument, table.u, table.redraw, table.serial)
    except UsageError as error:
        raise TableProblems([("u", str(error))]) from None


def _has(run: Run, column: str) -> bool:
    return column in run.columns or column.removeprefix("temp_").removesuffix("_C") in run.series
