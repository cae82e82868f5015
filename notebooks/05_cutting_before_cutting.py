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
# # 5. Cutting before cutting: a shaft from the lathe, before it is turned
#
# The scenario of `vcmm new turned_shaft`: ball end, journal, taper and seat. Which source owns which diameter, and what does a
# Z slide that leans against the spindle do?

# %%
from dataclasses import replace

import numpy as np

import vcmm
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up

scenario = vcmm.load_cut(vcmm.example("turned_shaft"))
result = vcmm.cut(scenario, trials=1000)
for c in result.uncertainty.characteristics[:4]:
    owner = max(result.shares[c.name], key=result.shares[c.name].get)
    said = c.decision.text if c.decision else ""
    print(
        f"{c.name:18s} {(c.value - c.nominal) * 1e3:+6.2f} um  U {c.expanded * 1e3:5.2f} um  {owner:8s} {said}"
    )

# %%
result.plot()

# %% [markdown]
# By hand: a Z slide out of parallel with the spindle by 15 urad makes a cylinder 2 x 15e-6 = 0.3 um of diameter thicker per
# 10 mm of length. The same from the virtual part, radius by radius, with nothing else wrong:

# %%
lean = [e for e in scenario.machine.effects if e.name == "squareness" and e.where == "B0Z"]
plain = replace(scenario, machine=replace(scenario.machine, effects=tuple(lean), inputs=()), inputs=())
task, world, _ = finished_part(set_up(plain))
rows = task.touches.rows["seat"]
radius = world.contacts.surface(world.tool.errors() - world.tool.known_error)[rows] * 1e3
z = task.touches.points[rows][:, 2]
slope = np.polyfit(z, radius - world.contacts.surface(0 * world.tool.known_error)[rows] * 1e3, 1)[0]
print(f"{abs(slope) * 2 * 10:.3f} um of diameter per 10 mm")
assert np.isclose(abs(slope) * 2 * 10, 0.3, rtol=0.02)
