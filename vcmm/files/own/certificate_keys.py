"""Keys of [certificate] as data sheets and editions of ISO 10360 write them, and remarks on limits to be checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vcmm.files.own.certificate_findings import NO_EFFECT
from vcmm.task.certification.certificate import MachineCertificate

# what the program calls a limit -> the keys that state it: ISO 10360-2:2009, -5:2020, -5:2010
KEYS_OF_LIMITS: dict[str, tuple[str, ...]] = {
    "E0": ("E0_MPE",),
    "E150": ("E150_MPE",),
    "R0": ("R0_MPL", "R0_MPE"),
    "form": ("P_Form_Sph_1x25", "P_Form_Sph_1x25_MPE", "PFTU_MPE"),
    "size": ("P_Size_Sph_1x25", "P_Size_Sph_1x25_MPE", "PSTU_MPE"),
}
# symbols of earlier editions of ISO 10360 (MPE_E and MPE_P of 10360-2:2001), as data sheets write them -> the key of today
OLDER_KEYS: Mapping[str, str] = {
    "MPE_E": "E0_MPE", "MPEE": "E0_MPE", "E_MPE": "E0_MPE", "MPE_E0": "E0_MPE", "E0": "E0_MPE", "EL_MPE": "E0_MPE",
    "MPE_E150": "E150_MPE", "E150": "E150_MPE",
    "MPE_P": "PFTU_MPE", "MPEP": "PFTU_MPE", "P_MPE": "PFTU_MPE", "MPE_PFTU": "PFTU_MPE", "PFTU": "PFTU_MPE", "MPE_PSTU": "PSTU_MPE", "PSTU": "PSTU_MPE",
    "MPL_R0": "R0_MPL", "R0": "R0_MPL", "MPE_THP": "THP_MPE", "MPETHP": "THP_MPE",
    "P_FTE_MPE": "PFTE_MPE", "P_STE_MPE": "PSTE_MPE", "P_LTE_MPE": "PLTE_MPE", "P_FTM_MPE": "PFTM_MPE", "P_STM_MPE": "PSTM_MPE", "P_LTM_MPE": "PLTM_MPE",
    "P_FTU_MPE": "PFTU_MPE", "P_STU_MPE": "PSTU_MPE",
}  # fmt: skip
# of several styli or orientations of a head: the machines that are drawn have one stylus
SEVERAL_STYLI = (
    "P_Form_Sph_5x25_MPE", "P_Size_Sph_5x25_MPE", "L_Dia_5x25_MPE", "PFTE_MPE", "PSTE_MPE", "PLTE_MPE", "PFTM_MPE", "PSTM_MPE", "PLTM_MPE", "THP_MPE",
)  # fmt: skip
OF_SCANS = ("THP", "THP_MPE", "P_Form_Sph_Scan", "P_Size_Sph_Scan")
STYLI = "what several styli add is stated by [plan] qualification = { sphere_diameter = ... }"
SCANS = "machines are drawn that touch point by point; what a scan adds is stated by [repeatability] and [[inputs]]"
GROWTH = (50.0, 1500.0)  # mm per um
SHORTEST = (1e-4, 1e-2)  # mm: E0 of the shortest length
FARTHEST = 1000.0  # mm: E150 is compared with E0 up to here
FORMS = 5.0  # between P_Form and E0 of the shortest length there is no more than this on data sheets


def stated_keys(table: Any, limit: str) -> list[str]:
    """Return the keys by which a table states a limit."""
    return [k for k in KEYS_OF_LIMITS[limit] if getattr(table, k) is not None]


def certificate_remarks(table: Any, c: MachineCertificate) -> tuple[str, ...]:
    """Return remarks on limits that are not used, or that do not go together, each with the usual range; empty when there are none."""
    key = {limit: next(iter(stated_keys(table, limit)), "") for limit in KEYS_OF_LIMITS}
    out = [
        f"[certificate] {k} has no effect: {SCANS if k in OF_SCANS else 'machines are drawn with one stylus; ' + STYLI}"
        for k in SEVERAL_STYLI
        if getattr(table, k) is not None
    ]
    out += [
        f"[certificate.measured] {k} has no effect: {SCANS if k in OF_SCANS else 'machines are drawn with one stylus; ' + STYLI}"
        for k in table.measured or {}
        if k in NO_EFFECT
    ]
    out += [*_of_lengths(key, c), *_of_repeats(key, c)]
    return tuple(out)


def _of_lengths(key: dict[str, str], c: MachineCertificate) -> list[str]:
    out = []
    for name, limit in (("E0", c.E0), ("E150", c.E150)):
        if limit is None:
            continue
        if limit.per != float("inf") and not GROWTH[0] <= limit.per <= GROWTH[1]:
            out.append(
                f"[certificate] {key[name]} grows by L/{limit.per:g}; usual are L/50 to L/1500: check it"
            )
        if not SHORTEST[0] <= limit(0.0) <= SHORTEST[1]:
            out.append(
                f"[certificate] {key[name]} allows {_um(limit(0.0))} on the shortest length; usual are 0.1 to 10 um: check the unit"
            )
    if (e0 := c.E0) and (e150 := c.E150):
        places = (0.0, e0.corner, e150.corner, FARTHEST)
        worst = max(places, key=lambda n: e0(n) / max(e150(n), 1e-12))
        if e150(worst) < e0(worst) * (1.0 - 1e-9):
            out.append(
                f"[certificate] E150_MPE ({_um(c.E150(worst))} at {worst:g} mm) is below E0_MPE ({_um(c.E0(worst))}): an offset stylus measures "
                "no better than none; usual are 1 to 2 times E0: check whether the two are exchanged"
            )
    return out


def _of_repeats(key: dict[str, str], c: MachineCertificate) -> list[str]:
    out = []
    if c.R0 is not None and c.form is not None and 2.0 * c.form < c.R0:
        # a length has two touches, and 25 touches of the sphere scatter by less than P_Form
        out.append(
            f"[certificate] {key['R0']} ({_um(c.R0)}) is more than twice {key['form']} ({_um(c.form)}): touches that scatter so much show in "
            "the form of the sphere; usual are 0.5 to 2 times it: check the unit"
        )
    if c.R0 is not None and c.E0 and 2.0 * c.E0(0.0) < c.R0:
        out.append(
            f"[certificate] {key['R0']} ({_um(c.R0)}) is more than twice E0_MPE of the shortest length ({_um(c.E0(0.0))}), which bounds the "
            "range of repeats by itself; usual are 0.3 to 1 times it: check the unit"
        )
    if c.form is not None and c.E0 and c.E0(0.0) > 0 and not 1 / FORMS <= c.form / c.E0(0.0) <= FORMS:
        out.append(
            f"[certificate] {key['form']} ({_um(c.form)}) is {c.form / c.E0(0.0):.2g} times E0_MPE of the shortest length ({_um(c.E0(0.0))}); "
            "usual are 0.5 to 2 times it: check the unit"
        )
    return out


def _um(mm: float) -> str:
    return f"{1e3 * mm:.4g} um"
