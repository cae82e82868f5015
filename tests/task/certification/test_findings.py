"""What the acceptance test found: an observation, which machines are drawn by; refused by name above its limit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from tests.task.certification.task import scenario_with
from vcmm.core.errors import DataError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.files.own.scenario import load_scenario
from vcmm.task.certification.certificate import LengthLimit, MachineCertificate
from vcmm.task.certification.findings import Finding, Findings, LimitShare
from vcmm.task.certification.knowledge import certified_knowledge, machines_at_each_limit
from vcmm.task.certification.lines import length_run, seven_lines
from vcmm.task.certification.machines import error_tables, half_sphere, per_mode, tip_harmonics

AXES = {"X": Axis("X", (0.0, 600.0)), "Y": Axis("Y", (0.0, 500.0)), "Z": Axis("Z", (-400.0, 0.0))}
BARE = Machine("m", "cmm", parse_structure("w b Y X Z t"), AXES)
LIMITS: Mapping[str, str] = {
    "E0_MPE": "1.8 um + L/350",
    "R0_MPL": "1.5 um",
    "P_Form_Sph_1x25": "1.8 um",
    "P_Size_Sph_1x25": "1 um",
}


def test_a_figure_may_have_been_two_standard_uncertainties_larger() -> None:
    assert Finding(1.2e-3, 0.15e-3).highest == pytest.approx(1.5e-3, rel=1e-14)
    assert Finding(1.2e-3).highest == 1.2e-3


def found(**named: object) -> MachineCertificate:
    findings = Findings(**named)  # type: ignore[arg-type]
    return MachineCertificate(
        E0=LengthLimit(1.8e-3, 350), R0=1.5e-3, form=1.8e-3, size=1e-3, findings=findings
    )


def used(c: MachineCertificate) -> np.ndarray:
    """(m, 35) mm: errors of the lengths by geometry alone."""
    bare = Machine("m", "cmm", BARE.chain, BARE.axes, tuple(error_tables(BARE)[0]))
    run, _ = length_run(bare, seven_lines(bare))
    return np.abs(machines_at_each_limit(BARE, c).modes @ per_mode(bare, run).T)


def test_every_limit_is_used_by_itself() -> None:
    """Geometry alone meets E0 on the worst of 35 lengths, the tip alone P_Form on 25 points; a diameter errs by P_Size."""
    c = found()
    drawn = machines_at_each_limit(BARE, c)
    lengths = length_run(BARE, seven_lines(BARE))[1]
    assert (used(c) / (1.8e-3 + 1e-3 * lengths / 350)).max(axis=1) == pytest.approx(
        np.ones(len(drawn.scatter))
    )
    columns = np.column_stack([np.ones(25), half_sphere()])
    left = np.eye(25) - columns @ np.linalg.pinv(columns)
    form = np.ptp(drawn.form @ tip_harmonics(half_sphere()).T @ left, axis=1)
    assert np.median(form) == pytest.approx(1.8e-3, rel=1e-3)
    assert form.max() <= 1.8e-3 * 1.001  # where pairs of touches would exceed E0 it is less
    assert np.abs(2 * drawn.radius) == pytest.approx(1e-3)


def test_scatter_from_the_range_that_was_found() -> None:
    """R0 = 0.6 um is the largest of 35 ranges of three lengths of two touches: own count of that range for unit scatter."""
    rng = np.random.default_rng(77)
    touches = rng.normal(size=(20_000, 35, 3, 2))
    lengths = touches[..., 1] - touches[..., 0]
    unit = (lengths.max(axis=2) - lengths.min(axis=2)).max(axis=1)
    drawn = machines_at_each_limit(BARE, found(R0=Finding(0.6e-3)))
    assert np.median(drawn.scatter) == pytest.approx(0.6e-3 * np.median(1 / unit), rel=0.01)
    assert np.quantile(drawn.scatter, 0.9) == pytest.approx(0.6e-3 * np.quantile(1 / unit, 0.9), rel=0.02)


def test_geometry_as_large_as_it_was_found() -> None:
    """The largest of 35 errors is 1.1 um; told by lengths it is found again where all of them are told as shares of E0."""
    assert used(found(largest=Finding(1.1e-3))).max(axis=1) == pytest.approx(1.1e-3)
    one = ((300.0, Finding(-0.5e-3)),)
    few, many = (used(found(lengths=rows)).max(axis=1) for rows in (one, one * 60))
    assert np.median(many) < np.median(few)  # one length may have missed what the machine can do
    assert few.max() <= 1.8e-3 + 1e-3 * np.sqrt(600**2 + 500**2 + 400**2) / 350 + 1e-9


def test_the_largest_error_as_a_share_of_its_limit() -> None:
    """Largest |E| = 60 % of MPE: the largest E/MPE of the 35 lengths is 0.6. With u = 0.15 um at a length of 600 mm, MPE 1.8 + 600/350 = 3.514 um,
    its standard uncertainty is 0.0427; lengths are 85 to 790 mm, so it lies between 0.15 / 4.06 = 0.037 and 0.15 / 2.04 = 0.074.
    """
    lengths = length_run(BARE, seven_lines(BARE))[1]
    limit = 1.8e-3 + 1e-3 * lengths / 350
    assert (used(found(worst=LimitShare(0.6))) / limit).max(axis=1) == pytest.approx(0.6)
    shares = (used(found(worst=LimitShare(0.6, u=0.15e-3))) / limit).max(axis=1)
    assert shares.mean() == pytest.approx(0.6, abs=0.003)
    assert 0.037 < shares.std() < 0.074
    assert LimitShare(0.6, u=0.15e-3).u_at(np.array([3.514e-3]))[0] == pytest.approx(0.0427, abs=5e-5)


def test_a_share_and_figures_without_effect_are_read(tmp_path: Path) -> None:
    for said in (
        '"60 %"',
        '{ error = "60 % of MPE", u = "0.15 um" }',
        '{ error = "60% of the E0_MPE", u = "8 %" }',
    ):
        machine = load_scenario(
            scenario_with(tmp_path, LIMITS, f'E0_largest = {said}\nPLTE = "1 um"\nTHP = "2 um"')
        ).machine
        assert any("found largest E0 60% of its limit" in i.evidence for i in machine.inputs)
        told = " ".join(machine.remarks)
        assert "[certificate.measured] PLTE has no effect: machines are drawn with one stylus" in told
        assert (
            "[certificate.measured] THP has no effect: machines are drawn that touch point by point" in told
        )
    for said, why in (
        ('"120 %"', "120% of E0_MPE is more than it allows"),
        ('"so %"', 'write "60 %" of MPE'),
    ):
        with pytest.raises(DataError, match=why):
            load_scenario(scenario_with(tmp_path, LIMITS, f"E0_largest = {said}"))


def test_what_was_found_is_no_mere_bound() -> None:
    def bounds(c: MachineCertificate) -> dict[str, bool]:
        return {i.parameter: i.bound for i in certified_knowledge(BARE, c).inputs}

    assert all(bounds(found()).values())
    assert bounds(found(form=Finding(1e-3))) == dict.fromkeys(("modes", "value", "coefficients", "dr"), True)
    both = bounds(found(R0=Finding(1e-3), form=Finding(1e-3)))
    assert both == {"modes": True, "value": False, "coefficients": False, "dr": True}


def test_two_names_and_two_ways_of_writing(tmp_path: Path) -> None:
    written = (
        'P_Form = "0.45 um"\nR0 = "0.4 um"',
        'PFTU = "0.45 um"\nR0 = { error = "0.4 um" }',
        'P_Form_Sph_1x25 = { error = "0.45 um", u = "0 um" }\nR0 = "0.4 um"',
    )
    scatters = []
    for measured in written:
        machine = load_scenario(scenario_with(tmp_path, LIMITS, measured)).machine
        assert any("found R0 0.4 um, P_Form 0.45 um" in i.evidence for i in machine.inputs)
        scatters.append(next(i.law.u for i in machine.inputs if i.redraw == "touch"))  # type: ignore[union-attr]
    assert scatters[0] == scatters[1] == scatters[2]


@pytest.mark.parametrize(
    ("measured", "message"),
    [
        ('R0 = "1.6 um"', "measured R0: 1.6 um is more than its limit of 1.5 um"),
        ('P_Form = "2 um"', "measured P_Form: 2 um is more than its limit of 1.8 um"),
        ('PSTU = "1.2 um"', "measured P_Size: 1.2 um is more than its limit of 1 um"),
        (
            'E0 = [{ length = "350 mm", error = "-2.9 um" }]',
            "measured E0 at 350 mm: 2.9 um is more than E0_MPE allows there (2.8 um)",  # 1.8 + 350 / 350
        ),
        # the longest length is sqrt(600^2 + 500^2 + 400^2) = 877.5 mm: 1.8 + 2.507 um
        (
            'E0_largest = { error = "4.4 um" }',
            "E0_largest: 4.4 um is more than E0_MPE allows on the longest length",
        ),
        ('R1 = "1 um"', 'no figure "R1"'),
        ('R0 = "-1 um"', "never negative"),
        ("R0 = 1.2", "R0 is a value such as"),
        ('R0 = { value = "1 um" }', "a table with error and u"),
        ('E0 = "1 um"', "one entry a length"),
        ('E0 = [{ error = "1 um" }]', "states no length"),
        ('P_Form = "1 um"\nPFTU = "1 um"', "stated twice"),
        ('R0 = { error = "1 um", u = "-0.1 um" }', "standard uncertainty and never negative"),
    ],
)
def test_findings_that_cannot_be(tmp_path: Path, measured: str, message: str) -> None:
    with pytest.raises(DataError) as caught:
        load_scenario(scenario_with(tmp_path, LIMITS, measured))
    assert message in str(caught.value)
    assert "task.toml:" in str(caught.value)
