"""Numbers with units, poses and runs, the effect as an interface, the machine that carries effects, what is known of them."""
