"""Motion of the machine under a program in time: curves, blends, servo, time law, toolpath."""
