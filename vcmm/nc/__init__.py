"""NC programs: what they mean, how long they take, and how they are rewritten."""

from vcmm.nc import front_ends as front_ends  # registers Sinumerik and Klartext
