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
# # Which error shows in which feature?
#
# A circle-diamond-square piece of our own drawing, cut virtually with one error of the machine at a time.

# %%
import numpy as np

import vcmm

piece = vcmm.twin("test_piece")  # scenarios/test_piece/*.py
scenario = vcmm.load_cut(vcmm.example("test_piece"))
result = piece.twin.run(scenario)
for shown in piece.page.tables(result):
    print(shown.title, "/ um")
    print(vcmm.tables.text(shown), end="\n\n")

# %% [markdown]
# By hand: with 10 urad between X and Y the cutter's centre, on a radius of 62 mm, is off by -c 62 sin a cos a along the
# normal, an oval of 0.31 um at 45 degrees; the sides of the square, 152 mm long, are 1.52 um out of square.

# %%
row = dict(zip(result.features, result.um[0]))
assert np.isclose(row["oval at 45°"], -0.31, atol=0.01)
assert np.isclose(row["square corner"], 1.52, atol=0.01)
