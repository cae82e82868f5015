"""vcmm calibrate of poses: geometry, elastic joints and eccentric gears of an arm from poses seen by a tracker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.face.cli.calibrate_given import CalibrationFiles
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.arm_machine import arm_texts
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_data import is_poses, load_poses
from vcmm.learn.calibration.arm import ArmFit, fit_arm
from vcmm.learn.calibration.pose_tests import PoseTest, put_to_poses
from vcmm.physics.structure.elastic_joint import ElasticJoint
from vcmm.physics.structure.scatter import Scatter
from vcmm.show.console.files import output_folder, write_files
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.tables.arm import (
    LINKS,
    POSE_TESTS,
    TERMS,
    arm_answers,
    further_rows,
    further_table,
    link_rows,
    links_table,
    pose_tests,
    term_rows,
)
from vcmm.show.tables.table import records
from vcmm.task.response.poses import PoseReadings, TrackerPlacement, settle_placement, tool_frames

REPORTED_POSE_SIGMAS = 4.5  # standard deviations from which a pose is reported
TOLD = 6  # poses that are named
FEW = 3.0  # misses in scatters of poses predicted from the others, from which they are reported


class ArmInput(NamedTuple):
    """Poses to calibrate from, poses to predict, and the nominal arm."""

    poses: list[PoseReadings]
    tests: list[PoseReadings]
    machine: Machine


class ArmFound(NamedTuple):
    """The fit, the rms of a coordinate with the nominal arm, and the tests of the file read back."""

    fit: ArmFit
    before: float
    tests: list[PoseTest]


@dataclass(frozen=True)
class ArmJob(Job[ArmInput, ArmFound]):
    """Poses in, a machine file with its joint covariance out."""

    request: CalibrationFiles
    schema = "vcmm.arm/1"

    def check(self) -> None:
        others = [f.name for f in (*self.request.files, *self.request.test) if not is_poses(f)]
        if others:
            raise UsageError(
                f'poses are calibrated by themselves, and {", ".join(others)} is of another kind; give the recordings of kind "pose" alone'
            )
        if self.request.machine is None:
            raise UsageError(
                "poses need the nominal arm: name its machine file with --machine (structure, and of every joint centre and direction); "
                "--structure alone says nothing of its links"
            )
        if self.request.out is not None:
            output_folder(self.request.out.parent)

    def load(self) -> ArmInput:
        assert self.request.machine is not None
        machine = load_machine(self.request.machine)
        stated = [e.id for e in machine.effects if not isinstance(e, Scatter)]
        if stated:
            raise UsageError(
                f"{self.request.machine}: the arm has errors already ({', '.join(stated[:4])}); a calibration from poses starts from the nominal arm: "
                "name the file without them"
            )
        return ArmInput(
            [load_poses(p, machine) for p in self.request.files],
            [load_poses(p, machine) for p in self.request.test],
            machine,
        )

    def run(self, loaded: ArmInput, report: Progress) -> ArmFound:
        poses, tests, machine = loaded
        report("geometry, elastic and eccentric joints", 0.1)
        fit = fit_arm(poses, machine)
        before = np.concatenate([_residuals_of(p, machine) for p in poses])
        out = self.request.out
        after = fit.machine
        if out is not None:
            assert self.request.machine is not None
            write_files(
                out.parent, arm_texts(fit, self.request.machine, out, [f.name for f in self.request.files])
            )
            say(f"wrote {out}, {out.stem}_errors.csv, {out.stem}_covariance.csv")
            after = load_machine(out)
        at_poses = [put_to_poses(t, machine, after, fit.placements[0]) for t in tests]
        return ArmFound(fit, float(np.sqrt(np.mean(before**2))), at_poses)

    def record(self, loaded: ArmInput, result: ArmFound) -> Record:
        fit = result.fit
        position, turn = fit.rms
        body: dict[str, object] = {
            "machine": None if self.request.out is None else str(self.request.out),
            "poses": sum(p.n for p in fit.recordings),
            "rms_before_um": result.before * 1e3,
            "rms_after_um": position * 1e3,
            "rms_left_out_um": fit.press * 1e3,
            "turn_after_urad": turn * 1e6 if turn else None,
            "u_um": fit.u[0] * 1e3,
            "links": records(LINKS, link_rows(fit)),
            "terms": records(TERMS, term_rows(fit)),
            "redundant": [{"name": r.name, "done_by": [n for n, _ in r.by]} for r in fit.redundant],
            "placements": [_placement(r, p) for r, p in zip(fit.recordings, fit.placements)],
            "tests": records(POSE_TESTS, result.tests),
        }
        return Record(body, self.request.read(), warnings=remarks(fit))

    def show(self, loaded: ArmInput, result: ArmFound) -> None:
        fit = result.fit
        show_answers(arm_answers(fit, result.before, result.tests))
        show_table(links_table(link_rows(fit)))
        more = further_rows(fit)
        if more:
            show_table(further_table(more))
        if result.tests:
            show_table(pose_tests(result.tests))
        for combination in fit.redundant:
            print(f"not separated: {combination.text}")
        say_warnings(remarks(fit))


def _residuals_of(poses: PoseReadings, machine: Machine) -> np.ndarray:
    """Return position departures with the nominal arm, (n, 3)."""
    frames = tool_frames(machine, poses.run)
    return np.asarray(poses.position - settle_placement(poses, frames).predict(frames)[0])


def _placement(poses: PoseReadings, place: TrackerPlacement) -> dict[str, object]:
    return {
        "recording": poses.name,
        "tracker_turn": place.turn.tolist(),
        "tracker_shift_mm": place.shift.tolist(),
        "target_mm": place.offset.tolist(),
        "target_turn": place.target.tolist() if poses.orientation is not None else None,
    }


def remarks(fit: ArmFit) -> list[str]:
    """Return remarks on outlying poses, numbers that poses hardly determine, stated noise that is too small, and the meaning of deflections."""
    out = []
    for poses, (position, _) in zip(fit.recordings, fit.residual):
        size = np.abs(position).max(axis=1) / fit.u[0]
        far = np.flatnonzero(size > REPORTED_POSE_SIGMAS)
        if len(far):
            lines = poses.lines if poses.lines is not None else np.arange(poses.n) + 1
            named = ", ".join(f"{lines[i]} ({size[i]:.1f} u)" for i in far[:TOLD])
            out.append(
                f"{poses.name}: poses that stand out by more than {REPORTED_POSE_SIGMAS} u, lines {named}; repeat or remove them"
            )
    if fit.recordings[0].u[0] and fit.u[0] > 1.4 * fit.recordings[0].u[0]:
        out.append(
            f"positions scatter by {fit.u[0] * 1e3:.1f} um, and {fit.recordings[0].u[0] * 1e3:.1f} um is stated: u of all numbers are from the scatter"
        )
    weak = [t.name for t in fit.terms if bool((fit.values(t)[1] > 0.5 * t.most).any())]
    if weak:
        out.append(f"these poses hardly tell {', '.join(weak)}: move all joints over more of their travel")
    if fit.press > FEW * fit.u[0]:
        out.append(
            f"each pose predicted from the others misses by {fit.press * 1e3:.1f} um, and positions scatter by {fit.u[0] * 1e3:.1f} um: the poses are too few or too alike "
            "for what is found; measure more (40 or more, all joints over most of their travel)"
        )
    if any(isinstance(t.effect, ElasticJoint) for t in fit.terms):
        out.append(
            "elastic_joint: numbers are compliance times the torque of weight at the cosine and sine of the summed angles; poses alone do not tell the "
            "stiffness from the mass. With another payload they change in proportion to the torque"
        )
    return out
