"""Numbers, units, poses and runs; effects and the machine that carries them. Imports nothing of vcmm outside this room."""
