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
# # 9. A year of one machine
#
# A machine file is the machine of one day. Here is a machine whose X scale drifts, goes with the season, and whose scale is replaced in September. A laser looks
# at it every other week. What is known of it each day, when was something not as expected, and what may be said of a part in February?

# %%
from pathlib import Path

import numpy as np

import vcmm

MACHINE = """vcmm = "machine/1"
name = "mill 4"
kind = "machine-tool"
structure = "w b Y X Z t"
axes.X = { travel = ["0 mm", "500 mm"] }
axes.Y = { travel = ["0 mm", "500 mm"] }
axes.Z = { travel = ["0 mm", "500 mm"] }
repeatability = { law = "normal", u = "1 um" }
[[effects]]
effect = "scale_factor"
axis = "X"
k = "0 um/m"
[[inputs]]
effect = "scale_factor"
axis = "X"
parameter = "k"
u = "4 um/m"
"""
Path("checks").mkdir(exist_ok=True)
Path("mill4.toml").write_text(MACHINE)

# %% [markdown]
# The year is drawn here, so that we know the truth: 6 um/m of wear in the year, 3 um/m of season, and 30 um/m on the first of September.

# %%
rng = np.random.default_rng(9)
positions = np.linspace(0.0, 500.0, 11)
days = np.arange(0, 365, 14)
truth = 6.0 * days / 365 + 3.0 * np.sin(2 * np.pi * days / 365.25) + np.where(days > 243, 30.0, 0.0)  # um/m
for day, k in zip(days, truth):
    date = str(np.datetime64("2026-01-01") + int(day))
    readings = -k * positions * 1e-3 + rng.normal(size=len(positions))  # um: indicated - true
    rows = "".join(f"{q:g},250,250,1,0,0,{d:.3f},1\n" for q, d in zip(positions, readings))
    Path(f"checks/laser_{date}.csv").write_text("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,u_um\n" + rows)
    Path(f"checks/laser_{date}.toml").write_text(
        f'vcmm = "recording/1"\ndata = "laser_{date}.csv"\nmachine = "../mill4.toml"\nkind = "displacement"\ndate = "{date}"\n'
        '[nuisance]\nzero = ""\n'
    )

# %% [markdown]
# All recordings, in the order of their dates. Each is predicted before it is used; one was not as predicted.

# %%
year = vcmm.track("mill4.toml", "checks", at="2027-02-01", explain=False)
for alarm in year.alarms:
    print(alarm.date, "not as predicted, chance", f"{alarm.chance:.1e};", alarm.suspects[0][0])
assert [a.date for a in year.alarms] == ["2026-09-10"]
k = year.course("scale_factor[X].k")
print("inside 1.96 u of the truth:", f"{np.mean(np.abs(k.value - truth) < 1.96 * k.u):.0%} of the checks")

# %%
year.plot("scale_factor[X].k")

# %% [markdown]
# The machine of a day is a machine file like any other, and its budget says what the time since the last check costs. By hand: the two faces of the part are 204 mm
# apart for the centres of the tip (4 mm), so that the line is 204 mm times what the scale may have gone since.

# %%
year.write("february")
Path("length.toml").write_text("""vcmm = "scenario/1"
machine = "february/machine.toml"
[part.features]
left = { type = "plane", point = "0 0 0 mm", normal = [-1, 0, 0], size = "40 40 mm" }
right = { type = "plane", point = "200 0 0 mm", normal = [1, 0, 0], size = "40 40 mm" }
[[part.characteristics]]
name = "length"
type = "distance"
between = ["left", "right"]
[pose]
shift = "100 250 250 mm"
[plan]
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }
styli.down = { offset = "0 0 0 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "left"
stylus = "down"
points = { strategy = "grid", n = [2, 2], margin = "5 mm" }
[[plan.steps]]
feature = "right"
stylus = "down"
points = { strategy = "grid", n = [2, 2], margin = "5 mm" }
""")
length = vcmm.uncertainty("length.toml", trials=20_000)["length"]
for line in length.budget:
    print(f"{line.input:45s} {line.u * 1e3:.2f} um  {line.share:.0%}")
since = next(b for b in length.budget if "time since calibration" in b.input)
by_hand = 204.0 * float(np.sqrt((year.dated.since**2).sum()))
assert abs(since.u - by_hand) < 1e-3 * by_hand

# %% [markdown]
# From the command line: `vcmm track mill4.toml checks --at 2027-02-01`; with `--task length.toml --limit "length = 3 um" --checks list.toml` it says which check is due
# next. See docs/track.md for how often all this is right.
