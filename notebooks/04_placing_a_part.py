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
# # 4. Placing a part
#
# The job of `vcmm place`, in Python: the pose, among those that the fixture allows, with the smallest uncertainty of what matters.
# For the command the goal is in the file; `vcmm place plate.toml --evaluations 500 --scan 128 --trials 5000` then gives the same:
#
#     [placement]
#     objective = { U = 1.0 }
#     weights = { "bore to front" = 1.0 }

# %%
import numpy as np

import vcmm
from vcmm.task.measuring.fixture import Fixture, Freedom, Goal, pose_of, six_of

scenario = vcmm.load_scenario(vcmm.example("plate"))

# %% [markdown]
# What may move, and what counts: anywhere on the table, turned about the vertical, and the distance of bore and front.

# %%
fixture = Fixture(
    (Freedom("x", -np.inf, np.inf), Freedom("y", -np.inf, np.inf), Freedom("turn_z", -np.pi, np.pi))
)
goal = Goal({"U": 1.0}, {"bore to front": 1.0})
found = vcmm.place(scenario, fixture=fixture, goal=goal, evaluations=500, scanned=128, trials=5000)
for name, at in (
    ("found", found.best),
    ("present", found.present),
    ("median", found.median),
    ("worst", found.worst),
):
    print(
        f"{name:8s} shift {np.round(at.pose[:3], 1)} mm, turn {np.degrees(at.pose[5]):6.1f} deg, U {at.value * 1e3:.4f} um"
    )

# %% [markdown]
# Is the gain real? Both poses with the same random numbers, from a seed that the search never saw.

# %%
sure = found.confirmation
print(
    f"gain {sure.gain * 1e3:.4f} um, standard error {sure.u_gain * 1e3:.4f} um; confirmed: {sure.is_confirmed}"
)
print(found.certificate.text)
found.plot()

# %% [markdown]
# Why? The influence that shrinks.

# %%
before, after = (
    next(c for c in r.characteristics if c.name == "bore to front") for r in (found.before, found.after)
)
old = {line.input: line.u for line in before.budget}
for line in sorted(after.budget, key=lambda line: -abs(line.u**2 - old[line.input] ** 2))[:3]:
    print(f"{line.input:30s} {old[line.input] * 1e3:.4f} -> {line.u * 1e3:.4f} um")

# %% [markdown]
# A pose is a value: measure there.

# %%
moved = scenario.at(pose_of(found.best.pose))
print(six_of(moved.pose)[:3], vcmm.measure(moved).values[1])

# %% [markdown]
# And what to do?

# %%
from vcmm.answer.placing.advice import advice

print("\n".join(advice(found)))

# %%
assert found.best.value <= found.present.value
