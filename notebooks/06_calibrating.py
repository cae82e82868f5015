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
# # 6. Calibrating: from recordings to a machine file to uncertainty
#
# A bridge CMM that has never been calibrated. A LaserTracer stood at six places and followed the tip through the volume; where it
# stood is known to a few hundredths of a millimetre, its dead paths not at all. `vcmm new traced_cmm` copies the files.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import vcmm
from vcmm.files.learned.calibrated_machine import machine_texts, residual_texts
from vcmm.files.learned.thermal_terms import thermal_text
from vcmm.files.own.library import folder
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.thermal import thermal_model
from vcmm.learn.calibration.verification import put_to_test
from vcmm.show.charts.canvas import canvas

lengths, bare = vcmm.load_recording(vcmm.example("traced_cmm"))
found = calibrate([lengths], bare)
print(f"{lengths.m} lengths; identified: {', '.join(found.identified.names)}")

# %% [markdown]
# Each curve with its band. A straightness has no slope (that is squareness), a positioning error and a rotation no mean.

# %%
figure, axes = plt.subplots(2, 2, figsize=(9, 5.5), layout="constrained")
for ax, name in zip(axes.flat, ("EXX", "EZX", "EYY", "EBX")):
    found.plot(name, ax=ax)

# %% [markdown]
# The machine file: a table of the curves, and the joint covariance of all its numbers. It is read back, and what it says is what was
# found.

# %%
home = folder() / "traced_cmm" / "machine.toml"
cmm = Path("cmm.toml")
for name, text in machine_texts(found, cmm, ["traced_cmm.toml"], home).items():
    Path(name).write_text(text)
machine = vcmm.load_machine(cmm)
nodes, value, u = found.band("EXX")
stored = next(e for e in machine.effects if e.about.is_calibrated and e.where == "EXX")
assert np.allclose(stored.values, value, atol=1e-9)

# %% [markdown]
# What is it worth? Never ask the readings it was made from. A laser along two body diagonals was kept back.

# %%
diagonal, _ = vcmm.load_recording(folder() / "traced_cmm" / "diagonal.toml")
test = put_to_test(diagonal, bare, machine)
print(f"before {test.before * 1e3:.2f} um, after {test.after * 1e3:.2f} um: {test.gain:.0%} less")
print(f"{test.inside:.0%} of {test.n} readings within their 95 % band (u {test.u * 1e3:.2f} um)")

# %% [markdown]
# With that table switched on in its control the machine is another one: no table any more, but what is not known of it stays.

# %%
compensated = Path("compensated.toml")
for name, text in residual_texts(found, compensated, ["traced_cmm.toml"], home, "cmm_errors.csv").items():
    Path(name).write_text(text)
TASK = """
vcmm = "scenario/1"
machine = "{machine}"
[part.features]
left = {{ type = "circle", point = "-150 -100 0 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }}
right = {{ type = "circle", point = "150 100 0 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }}
[[part.characteristics]]
name = "distance"
type = "distance"
between = ["left", "right"]
[pose]
shift = "300 250 -300 mm"
turn = "0 0 0 deg"
[plan]
touch = {{ speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }}
styli.down = {{ offset = "0 0 -120 mm", tip_diameter = "4 mm" }}
[[plan.steps]]
feature = "left"
stylus = "down"
points = {{ strategy = "even", n = 8 }}
[[plan.steps]]
feature = "right"
stylus = "down"
points = {{ strategy = "even", n = 8 }}
"""
for file in (cmm, compensated):
    task = Path(f"{file.stem}_task.toml")
    task.write_text(TASK.format(machine=file.name))
    (c,) = vcmm.uncertainty(vcmm.load_scenario(task)).characteristics
    print(f"{file.stem:12s} {c.name}: indicated - true {c.bias * 1e3:+.2f} um, U {c.expanded * 1e3:.2f} um")

# %% [markdown]
# A morning after switching on: a sphere on the table is touched every five minutes. Which sensor does the drift follow, and how late?

# %%
warm, _ = vcmm.load_recording(folder() / "traced_cmm" / "warm_up.toml")
model = thermal_model([warm], machine)
for term, amount, lag in zip(model.terms, model.amounts, model.lags):
    print(f"{term.where}: {amount * 1e3:.2f} um/K behind {lag:.0f} s")
print(f"{model.before * 1e3:.2f} -> {model.after * 1e3:.2f} um; not used: {model.unused_sensors}")
warm_file = Path("cmm_warm.toml")
warm_file.write_text(thermal_text(model, machine, cmm, warm_file, ["warm_up.toml"]))

time = warm.run.column("time_s") / 3600.0
warmed = vcmm.load_machine(warm_file)
ax = canvas(None)
ax.plot(time, 1e3 * warm.value, "o", markersize=3, label="read")
drift = -warmed.tip_error(warm.run)[:, 2] + machine.tip_error(warm.run)[:, 2]
ax.plot(time, 1e3 * (drift - drift.mean() + warm.value.mean()), label="machine file")
ax.set(xlabel="time / h", ylabel="µm", title="a fixed sphere, indicated - true along z")
_ = ax.legend(fontsize=8)
