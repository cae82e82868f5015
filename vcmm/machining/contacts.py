"""Contacts of a job: they are those of vcmm.cutting.contactmap, under the name that the job knows them by."""

from __future__ import annotations

from vcmm.cutting.contactmap import Contacts, Ints, Solids

__all__ = ["Contacts", "Ints", "Solids"]
