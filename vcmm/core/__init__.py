"""Core of vcmm: numbers with units, poses and runs, the interface of effects, the machine that carries them, and what is known about them."""
