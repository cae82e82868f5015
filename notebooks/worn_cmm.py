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
# # Diagnose: what physics does the machine file lack?
#
# The recording of `vcmm new worn_cmm`: a ball plate in five placements on a bridge CMM. Error = indicated - true.

# %%
from dataclasses import replace

import vcmm
from vcmm.diagnosis.improve import improved
from vcmm.library import path

recording, machine = vcmm.load_recording(path("worn_cmm"))
print(recording.name, recording.m, "observations,", ", ".join(sorted(recording.run.series)))

# %% [markdown]
# The answer: names with parameters and intervals, how probable each name is, what it cannot be told from.

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

# %% [markdown]
# Does it hold on rows that were never fitted? Each line leaves one part out, fits the named effects on the rest, predicts.

# %%
for fold in found.fit.held_out:
    print(f"{fold.fold:20s} rms {fold.rms_before * 1e3:.3f} -> {fold.rms_after * 1e3:.3f} um")

# %% [markdown]
# The improved machine serves every other job. Here: the plate, measured in a room at 22 degC.

# %%
job = vcmm.load_scenario(path("plate"))
job = replace(job, constants={**job.constants, "temp_air_C": 22.0})
better = improved(job.machine, tuple((a.fitted, a.inputs) for a in found.answer))
for name, one in (("as filed", job.machine), ("as diagnosed", better)):
    for c in vcmm.uncertainty(replace(job, machine=one), trials=20_000).characteristics[:2]:
        print(f"{name:13s} {c.name:16s} {c.value:.5f} mm, U = {c.expanded * 1e3:.2f} um")
