"""[record] of a scenario, a machine file or a recording: people, dates, serial numbers; words for the head of a report."""

from __future__ import annotations

from pydantic import Field

from vcmm.files.schema import Table


class RecordTable(Table):
    by: str = Field(default="", examples=['"A. Person"'])
    date: str = Field(default="", examples=['"2026-11-22"'])
    laboratory: str = ""
    machine_serial: str = ""
    machine_certificate: str = ""
    probe: str = ""
    reference_sphere: str = Field(default="", examples=['"25 mm, SN 7; certificate 2026-118"'])
    standards: str = Field(default="", examples=['"step gauge SN 3; certificate 2026-031"'])
    thermometers: str = Field(default="", examples=['"part sensor SN 9; certificate 2026-204"'])
    part_serial: str = ""
    drawing: str = Field(default="", examples=['"D-1234 rev. B"'])
    order: str = ""
    remarks: str = ""

    @property
    def entries(self) -> dict[str, str]:
        """Entries that are not empty."""
        return {k: v for k, v in self.model_dump().items() if v}
