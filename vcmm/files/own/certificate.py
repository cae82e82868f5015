"""Read [certificate] of a machine file: limits in words to a MachineCertificate."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError, choose_from
from vcmm.files.own.certificate_findings import findings_in
from vcmm.files.own.certificate_keys import stated_keys
from vcmm.files.own.machine_tables import CertificateTable, MachineFile, found_machine
from vcmm.files.problems import TableProblems
from vcmm.files.schema import read_model
from vcmm.task.certification.certificate import POSITIONING, MachineCertificate, length_limit, short_limit


def certificate_from(table: CertificateTable) -> MachineCertificate:
    """Raises TableProblems with every limit that is not understood, UsageError for limits that contradict one another."""
    problems_found: list[tuple[str, str]] = []

    def limit(name: str, read: object) -> object:
        keys = stated_keys(table, name)
        if not keys:
            return None
        key = keys[0]
        problems_found.extend(
            (other, f"{other} and {key} state the same limit; keep one of them") for other in keys[1:]
        )
        try:
            return read(getattr(table, key), key)  # type: ignore[operator]
        except UsageError as error:
            problems_found.append((key, str(error)))
            return None

    lengths = {name: limit(name, length_limit) for name in ("E0", "E150")}
    values = lengths | {name: limit(name, short_limit) for name in ("R0", "form", "size")}
    positioning = _positioning(table.iso230_2 or {}, problems_found)
    findings = findings_in(table.measured or {}, problems_found)
    if problems_found:
        raise TableProblems(problems_found)
    return MachineCertificate(**values, positioning=positioning, prior=table.prior, findings=findings)  # type: ignore[arg-type]


def _positioning(
    table: dict[str, str], problems_found: list[tuple[str, str]]
) -> dict[tuple[str, str], float]:
    out = {}
    for key, text in table.items():
        figure, _, axis = key.partition(" ")
        try:
            if figure not in POSITIONING or axis not in ("", "X", "Y", "Z"):
                raise UsageError(
                    f'iso230_2: no figure "{key}".{choose_from(figure, POSITIONING)} With its axis: "A X"'
                )
            out[figure, axis] = short_limit(text, key)
        except UsageError as error:
            problems_found.append(("iso230_2", str(error)))
    return out


def certificate_table(path: str | Path) -> dict[str, Any]:
    """Return [certificate] of the machine of a scenario, as written. UsageError where there is none."""
    _, table, _ = found_machine(path)
    certificate = table.get("certificate")
    if not isinstance(certificate, dict) or not certificate:
        raise UsageError(
            'the machine states no certificate; add [machine.certificate] with E0_MPE = "1.8 um + L/350" (vcmm new certificate)'
        )
    return certificate


def stated_certificate(path: str | Path) -> MachineCertificate | None:
    """Return the certificate that a machine file, or the machine of a scenario, states, whether or not its errors come from it."""
    document, table, at = found_machine(path)
    model = read_model(MachineFile, {"vcmm": "machine/1", **table}, document, at)
    return None if model.certificate is None else certificate_from(model.certificate)
