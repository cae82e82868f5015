"""Simulate the shop: the motion of the machine in time, the cut, and the deviations of the part before it is cut."""
