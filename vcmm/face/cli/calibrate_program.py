"""vcmm calibrate program: the touches of a plan as a program of the control, its recording file and its set-up file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

SAME = 1e-3  # mm: touches read back lie this near to those of the plan; programs state 0.1 um
ABOVE = 30.0  # mm: from the highest that a turning sphere reaches to where rotary axes may turn
STANDOFF = 10.0  # mm


def program_command(plan: Path, control: str, out: Path, tool: int, json: bool) -> int:
    """Write the program, read it back by what `vcmm nc` understands, and write the recording file for its log."""
    from vcmm.core.errors import VcmmError
    from vcmm.files.own.touch_plan import load_touch_plan, probing_job, recording_text, setup_text
    from vcmm.program.probing_program import LOG, probing_texts
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder, write_text
    from vcmm.show.console.terminal import say

    given = load_touch_plan(plan)
    chosen, minutes = _poses(given)
    job = probing_job(given, chosen, STANDOFF, ABOVE, tool)
    texts = probing_texts(job, control)
    texts["touch.toml"] = recording_text(given, LOG)
    texts["setup.toml"] = setup_text(given, job, control)
    farthest = _read_back(job, texts, control)
    if farthest > SAME:
        raise VcmmError(f"the program reads back {farthest:.4f} mm beside its plan; nothing is written")
    output_folder(out)
    for name, text in texts.items():
        write_text(out / name, text)
    body = {
        "control": control,
        "files": [str(out / name) for name in texts],
        "poses": len(chosen),
        "touches": len(job.touches),
        "minutes": minutes,
        "clear_mm": job.clear,
        "read_back": {"touches": len(job.touches), "farthest_mm": farthest},
    }
    if json:
        print_json(document("vcmm.probing_program/1", body, seed=None, files=sources(plan)))
    else:
        print(
            f"{len(job.touches)} touches at {len(chosen)} rotary positions, about {minutes:.3g} min; rotary axes turn at Z {job.clear:g} mm"
        )
        print(f"read back: {len(job.touches)} touches, farthest {farthest * 1e3:.2f} um from the plan")
        say(f"wrote {', '.join(str(out / name) for name in texts)}")
        say("collisions are not looked for: run it first above the table, with reduced rapids")
        say(
            f"next: copy {LOG} of the control beside touch.toml, then vcmm calibrate fit {out / 'touch.toml'} --machine machine.toml --out found.toml"
        )
    return 0


def _poses(given: Any) -> tuple[list[dict[str, float]], float]:
    """Rotary positions (rad): within the budget of the plan, else all."""
    from vcmm.face.cli.calibrate_poses import in_order_of_angles
    from vcmm.learn.calibration.design import PlannedSetup
    from vcmm.learn.calibration.pose_design import best_poses, pose_plan

    if given.budget is None or not any(len(q) > 1 for q in given.table.rotary.values()):
        return given.poses, given.table.minutes
    plan = pose_plan([PlannedSetup(*given.setup)], given.machine)
    chosen = best_poses(plan, given.budget)
    return [plan.candidates[i].angles for i in in_order_of_angles(plan, chosen)], plan.minutes(chosen)


def _read_back(job: Any, texts: dict[str, str], control: str) -> float:
    """mm by which a touch of the program, read as `vcmm nc` reads it, lies farthest beside the plan. Raises VcmmError where one is missing."""
    import numpy as np

    from vcmm.core.errors import VcmmError
    from vcmm.program.interpret import interpret
    from vcmm.program.setup import Setup, Tool

    probe = Tool(job.tool, length=100.0, diameter=2 * job.ball, shape="probe")
    setup = Setup(tools={job.tool: probe}, offsets={job.offset: (0.0, 0.0, 0.0)}, strict=False)
    read = interpret(next(iter(texts.values())), control, setup, job.name)
    if len(read.touches) != len(job.touches):
        raise VcmmError(
            f"the program reads back with {len(read.touches)} touches of {len(job.touches)}; nothing is written"
        )
    farthest = 0.0
    for one, met in zip(job.touches, read.touches):
        middle = np.array(met.tip) + [0.0, 0.0, job.ball]
        surface = middle + job.ball * np.array(one.way)
        turned = [float(np.radians(one.rotary.get(a, 0.0))) for a in "ABC"]
        beside = float(np.abs(surface - one.surface).max())
        arm = float(np.linalg.norm(one.surface)) * float(np.abs(np.array(met.rotary) - turned).max())
        farthest = max(farthest, beside, arm, 1e3 * float(np.abs(np.array(met.along) - one.way).max()))
    return farthest
