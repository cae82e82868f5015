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
# # The part comes back measured
#
# The scenario of `vcmm new measured_block`: a block was cut on a machine whose file says only squareness and scale, and
# measured at 236 points. Where does it depart from what was predicted, what is it, and does the next part come out better?

# %%
import matplotlib.pyplot as plt
import numpy as np

import vcmm
from vcmm.files.columns import run_columns
from vcmm.files.own.measured_data import read_measured_points
from vcmm.shop.machining.measured_part import measured_cut
from vcmm.shop.machining.part_recording import part_recording

file = vcmm.example("measured_block")
scenario = vcmm.load_cut(file)
points = read_measured_points(file.parent / "measured_block" / "points.csv")[0]
back = measured_cut(scenario, points, u_point=0.3e-3)
for found in back.mismatch:
    print(found.text)

# %% [markdown]
# The floors lie deeper the later they were cut. `diagnose` asks which physics does that.

# %%
machine = vcmm.load_machine(file.parent / "measured_block" / "mill.toml")
recording = part_recording("block", back, machine, frozenset(run_columns()))
diagnosis = vcmm.diagnose(recording, machine)
for answer in diagnosis.answer:
    print(
        answer.id,
        {k: f"{v.value:.4g} {v.unit}" for k, v in answer.parameters.items()},
        answer.cannot_be_told_from,
    )

# %%
floors = np.abs(back.normal[:, 2]) > 0.5
minutes = back.observed.run.column("time_s") / 60.0
growth = diagnosis.answer[0].fitted
figure, ax = plt.subplots(figsize=(7, 3.6))
ax.plot(minutes[~floors], back.departure[~floors] * 1e3, ".", color="0.7", label="walls, across the tool")
first = back.observed.run.labels["tool"] == "1"  # the length of each tool was set on its own, u = 2 um
for mine, mark in ((floors & first, "o"), (floors & ~first, "s")):
    number = back.observed.run.labels["tool"][mine][0]
    ax.plot(minutes[mine], back.departure[mine] * 1e3, mark, ms=4, label=f"floors, along tool {number}")
late = np.linspace(0.0, minutes.max(), 200)
drop = -growth.amplitude * (1.0 - np.exp(-late * 60.0 / growth.tau))
level = np.mean(back.departure[floors & first] - np.interp(minutes[floors & first], late, drop))
ax.plot(
    late,
    (drop + level) * 1e3,
    "-",
    label=f"spindle growth, {growth.amplitude * 1e3:.1f} um, {growth.tau:.0f} s",
)
ax.set_xlabel("time since the start of the program / min")
ax.set_ylabel("measured less predicted / um")
ax.legend()
figure.tight_layout()
figure.savefig("measured_block.png", dpi=120)

# %% [markdown]
# The concealed growth is 14 um with 900 s. What comes next are two commands, see docs/cut.md: `vcmm diagnose --out found` writes
# the machine file with the growth in it, and `vcmm compensate` takes that out of the next program.

# %%
assert diagnosis.answer[0].effect == "spindle_growth"
low, high = diagnosis.answer[0].parameters["A"].interval95
assert low < 14.0 < high
