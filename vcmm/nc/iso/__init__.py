"""The G-code family: Fanuc mill and lathe, LinuxCNC. Imports nc."""
