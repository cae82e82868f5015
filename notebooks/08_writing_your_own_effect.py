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
# # 8. Writing your own effect
#
# A physical effect is one small class: its name, its parameters, and the motion that it gives a link of the machine. Here a ram that hangs
# the lower the further it reaches out. In a file of `vcmm/physics/catalogue/` with its line in the list it serves every job, diagnosis and files too
# (CONTRIBUTING.md); in a notebook it serves what is computed from a machine value.

# %%
from dataclasses import dataclass, replace

import numpy as np

import vcmm
from vcmm.core.declaration import About
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.laws import Normal
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class RamDroop(Effect):
    """-c q_a^2 in Z: with c = 2 um/m^2 a ram reaching out 500 mm hangs 0.5 um low."""

    name = "ram_droop"
    per = "axis"
    about = About(cites="Euler-Bernoulli cantilever under its own weight, leading term")
    axis: str = at("Y", "axis along which the ram moves")
    c: float = param(0.0, "um/m^2", "sag per square of the reach")

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, Z=-self.c * run.q(self.axis) ** 2)


# %% [markdown]
# The number by hand first: 2 um/m² are 2e-9 per mm, and 2e-9 x 500² = 5e-4 mm.

# %%
run = Run({"Y": np.array([500.0])}, np.zeros((1, 3)))
assert np.allclose(RamDroop("Y", c=2e-9).error_motion(run), [[0, 0, -5e-4, 0, 0, 0]])

# %% [markdown]
# A machine is a frozen value: a copy of the plate's machine with the effect, 40 um/m², known to 10 %.

# %%
plate = vcmm.load_scenario(vcmm.example("plate"))
droop = RamDroop("Y", c=40e-9)
known = vcmm.Input("ram_droop", "Y", "c", Normal(4e-9))
machine = replace(
    plate.machine, effects=(*plate.machine.effects, droop), inputs=(*plate.machine.inputs, known)
)
sagging = replace(plate, machine=machine)

# %% [markdown]
# Where does it show? A field over the travels, and the tip at one place by hand.

# %%
there = Run({"X": np.zeros(1), "Y": np.array([300.0]), "Z": np.zeros(1)}, np.zeros((1, 3)))
change = replace(machine, effects=(droop,), inputs=()).tip_error(there)[0]
print(f"at Y = 300 mm the tip hangs by {-change[2] * 1e3:.2f} um")
assert np.isclose(change[2], -40e-9 * 300**2)
vcmm.field(machine, nodes=4).plot()

# %% [markdown]
# What does it do to the plate? Only what its touches see: the squareness of the bore to the top, a slope of the sag over the plate.

# %%
for before, after in zip(
    vcmm.uncertainty(plate, trials=20_000).characteristics,
    vcmm.uncertainty(sagging, trials=20_000).characteristics,
):
    line = next((b for b in after.budget if b.input == known.id), None)
    own = f"{line.u * 1e3:.4f} um of it by the sag" if line else "the sag is not seen"
    print(
        f"{before.name:20s} bias {before.bias * 1e3:+.3f} -> {after.bias * 1e3:+.3f} um, U {after.expanded * 1e3:.2f} um, {own}"
    )
