"""How a program moves the machine in time, what the tool cuts, and the part before it is cut."""
