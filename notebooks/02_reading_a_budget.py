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
# # 2. Reading a budget: a plate with a bore, from a scenario file to a decision
#
# The same job as `vcmm uncertainty plate.toml`, in Python. Error = indicated - true.

# %%
from dataclasses import replace

import vcmm

scenario = vcmm.load_scenario(vcmm.example("plate"))

# %% [markdown]
# One virtual measurement, all errors at their estimates: what would this machine indicate?

# %%
for value in vcmm.measure(scenario).values:
    print(f"{value.name:20s} nominal {value.nominal:9.5f}  indicated {value.value:9.5f} {value.unit}")

# %% [markdown]
# How well? Sizes and distances have a closed form; the squareness of the bore is an extreme value and is sampled.

# %%
result = vcmm.uncertainty(scenario)
for c in result.characteristics:
    print(f"{c.name:20s} y = {c.value:.5f} mm  U = {c.expanded * 1e3:.2f} um  {c.decision.text}  ({c.tier})")

# %% [markdown]
# Which influence contributes most to U? `redraw` says how often it is drawn anew, and that decides most of U.

# %%
for line in result.characteristics[0].budget[:4]:
    print(f"{line.input:32s} {line.redraw:8s} {line.u * 1e3:6.3f} um {line.share:6.1%}")
result.budget.plot()

# %% [markdown]
# The lines are a sum of squares, and so is u: GUM 5.1.2. What is missing from 100 % is interaction.

# %%
diameter = result.characteristics[0]
assert abs(sum(line.share for line in diameter.budget) + diameter.interaction_share - 1.0) < 1e-6
print(
    f"u = {sum(line.u**2 for line in diameter.budget) ** 0.5 * 1e3:.4f} um by the lines, {diameter.u * 1e3:.4f} um as stated"
)

# %% [markdown]
# What if the probe scattered twice as much? A machine is a frozen value: change a copy.

# %%
from vcmm.core.laws import StudentT

inputs = tuple(
    replace(i, law=StudentT(0.8e-3, 10)) if i.effect == "scatter" else i for i in scenario.machine.inputs
)
worse = replace(scenario, machine=replace(scenario.machine, inputs=inputs))
for before, after in zip(result.characteristics, vcmm.uncertainty(worse).characteristics):
    print(f"{before.name:20s} U {before.expanded * 1e3:.2f} -> {after.expanded * 1e3:.2f} um")

# %%
first = vcmm.uncertainty(worse).characteristics[0]
assert first.expanded > result.characteristics[0].expanded
