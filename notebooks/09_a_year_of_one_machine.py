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
# A machine file is the machine of one day. `vcmm new tracked_mill` writes a machining centre as it was known at the turn of the year, and 21 checks of the year
# after: a plate of spheres every fourth Monday, a ball bar every other month, a laser once, each with the temperatures of the scales. The screw of X wears, all scales go
# with the season, and once something happened. What is known of the machine each day, when was a check not as expected, which parts are doubtful, what can be stated about a part
# in February, and which check comes next?

# %%
from pathlib import Path

import numpy as np

import vcmm

TASK = vcmm.example("tracked_mill")  # a housing, measured by the probe in the spindle
MILL = TASK.with_suffix("")  # the folder beside it: machine.toml, checks, checks.toml, parts.csv

# %% [markdown]
# All recordings, in the order of their dates. Each is predicted before it is used; where it is not as predicted, `diagnose` is asked what changed.

# %%
year = vcmm.track(MILL / "machine.toml", MILL / "checks", at="2027-02-01")
for alarm in year.alarms:
    print(alarm.date, "not as predicted:", alarm.suspects[0][0])
    print(alarm.answer)
assert [a.date for a in year.alarms] == ["2026-06-22"]

# %%
year.plot("squareness[C0Y].angle")

# %% [markdown]
# X wears and goes with the season; the band grows where no check was.

# %%
year.plot("scale_factor[X].k")

# %% [markdown]
# The last ball bar, and what was forecast of it the moment before.

# %%
year.plot("2026-12-02_bar.toml XY")

# %% [markdown]
# What was measured or cut between the last good check and the alarm is doubtful. By hand: the bores lie 300 mm apart in X and 200 mm in Y, so that a squareness of 35 urad
# moves their distance by 35e-6 x 300 x 200 / 360.6 mm = 5.8 um.

# %%
(doubt,) = year.doubtful_parts(TASK, MILL / "parts.csv")
print("after", doubt.since, "until", doubt.alarm, ":", [p.name for p in doubt.parts])
for shift in doubt.shifts:
    print(
        f"{shift.name:8s} {shift.shift * (1e3 if shift.unit == 'mm' else 1e6):+.1f} {'um' if shift.unit == 'mm' else 'urad'}"
    )
bores = next(s for s in doubt.shifts if s.name == "bores")
jump = year.course("squareness[C0Y].angle").value[10] - year.course("squareness[C0Y].angle").value[9]  # urad
assert abs(bores.shift - jump * 1e-6 * 300 * 200 / 360.6) < bores.u

# %% [markdown]
# The machine of a day is a machine file like any other, and its budget says what the time since the last check costs. By hand: both faces are touched by a ball of 6 mm, so
# that its centres lie 406 mm apart, times what the slope of X and the expansion of its scale (at 19.2 degC) may have gone since.

# %%
year.write("february")
text = TASK.read_text(encoding="utf-8").replace("tracked_mill/machine.toml", "february/machine.toml")
Path("housing.toml").write_text(text, encoding="utf-8")
length = vcmm.uncertainty("housing.toml", trials=20_000)["length"]
for line in length.budget[:5]:
    print(f"{line.input:45s} {line.u * 1e3:.2f} um  {line.share:.0%}")
since = next(b for b in length.budget if "time since calibration" in b.input)
rows = year.followed.tracked.rows
slope = year.dated.since[rows["scale_factor[X].k"]] - 0.8 * year.dated.since[rows["scale_expansion[X].alpha"]]
assert abs(since.u - 406.0 * float(np.sqrt((slope**2).sum()))) < 1e-3 * since.u

# %% [markdown]
# Which check keeps the length below U = 2 um, and when is it due?

# %%
advice = year.next_checks(TASK, "length = 2 um", MILL / "checks.toml", days=90)
for one in advice.plan.checks:
    print(f"in {one.day} d: {one.check.name}, U after it {one.u_after['length'] * 1e3:.2f} um")
print("cost", advice.plan.cost, "; at a fixed interval:", advice.plan.fixed)
assert advice.plan.kept

# %% [markdown]
# From the command line: `vcmm new tracked_mill`, then the commands that it prints. See docs/track.md for how often all this is right.
