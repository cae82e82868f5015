# ---
# jupyter:
#   jupytext:
#     text_representation:
#       format_name: percent
#   kernelspec:
#     name: python3
#     display_name: Python 3
# ---

# %% [markdown]
# # 7. Diagnosing a log: what physics does the machine file lack?
#
# The recording of `vcmm new worn_cmm`: a ball plate in five placements on a bridge CMM. Error = indicated - true.

# %%
from dataclasses import replace

import vcmm
from vcmm.learn.diagnosis.improve import improve_machine

recording, machine = vcmm.load_recording(vcmm.example("worn_cmm"))
print(recording.name, recording.m, "observations,", ", ".join(sorted(recording.run.series)))

# %% [markdown]
# The answer: names with parameters and intervals, how probable each name is, what it cannot be distinguished from.

# %%
found = vcmm.diagnose(recording, machine, seed=1)
print(found.verdict)
for answer in found.answer:
    print(
        answer.effect, dict(answer.where), f"probability {answer.probability:.3f}, share {answer.share:.0%}"
    )
    for name, one in answer.parameters.items():
        low, high = one.interval95
        print(f"    {name} = {one.value:.2f} {one.unit}, 95 % {low:.2f} to {high:.2f}")

# %%
found.plot()

# %% [markdown]
# Does it hold on rows that were never fitted? Each line leaves one part out, fits the named effects on the rest, predicts.

# %%
for fold in found.fit.held_out:
    print(f"{fold.fold:20s} rms {fold.rms_before * 1e3:.3f} -> {fold.rms_after * 1e3:.3f} um")

# %% [markdown]
# The improved machine serves every other job. Here: the plate, measured in a room at 22 degC.

# %%
job = vcmm.load_scenario(vcmm.example("plate"))
job = replace(job, constants={**job.constants, "temp_air_C": 22.0})
better = improve_machine(job.machine, tuple((a.fitted, a.inputs) for a in found.answer))
for name, one in (("as filed", job.machine), ("as diagnosed", better)):
    for c in vcmm.uncertainty(replace(job, machine=one), trials=20_000).characteristics[:2]:
        print(f"{name:13s} {c.name:16s} {c.value:.5f} mm, U = {c.expanded * 1e3:.2f} um")

# %% [markdown]
# ## A log of a real machine
#
# The axis of a slit at a neutron source, moved to the same places from both sides and read by its resolver (ecmc_bifrost_slits_sat). The
# published table is not part of vcmm: where `VCMM_DATA` names the folder that holds it, it is diagnosed here; take your own table instead. What the
# machine file states is only what was known before: an axis, its travel, 0.1 um of scatter.

# %%
import csv
import os
from pathlib import Path

MACHINE = """
vcmm = "machine/1"
structure = "w b X t"
axes.X = { travel = ["0 mm", "100 mm"] }
repeatability = { law = "normal", u = "0.1 um" }
"""
RECORDING = """
vcmm = "recording/1"
data = "runs.csv"
machine = "axis.toml"
format = "iso230"
kind = "displacement"
history = "none"
line = { axis = "X" }
nuisance = { zero = "" }
"""
table = (
    Path(os.environ.get("VCMM_DATA", "")) / "data/recordings/iso230_2_linear_axis/slit_11358_axis2_tidy.csv"
)
if table.is_file():
    with table.open() as file:
        rows = [
            r for r in csv.DictReader(file) if r["test"] in ("accuracy", "repeatability") and r["resolver_mm"]
        ]
    with Path("runs.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["target_mm", "run", "direction", "actual_mm"])
        writer.writerows(
            [r["target_mm"], f"{r['test']} {r['run']}", r["approach"], r["resolver_mm"]] for r in rows
        )
    Path("axis.toml").write_text(MACHINE)
    Path("slit.toml").write_text(RECORDING)
    log, axis = vcmm.load_recording("slit.toml")
    diagnosis = vcmm.diagnose(log, axis, seed=1)
    print(f"{diagnosis.verdict}: {log.m} readings")
    for answer in diagnosis.answer:
        print(
            f"    {answer.effect} {dict(answer.where)}, {answer.share:.0%} of the excess, or {', '.join(answer.cannot_be_told_from) or 'nothing else'}"
        )
    assert any(
        a.effect in ("lost_motion", "backlash") for a in diagnosis.answer
    )  # what the makers found by least squares: 2.44 um
    diagnosis.plot()
else:
    print("VCMM_DATA does not name a folder with this table")
