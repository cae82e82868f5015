"""How a program moves the machine in time: curves, blends, servo, time law, toolpath."""
