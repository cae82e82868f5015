"""The G-code family: Fanuc mills and lathes, LinuxCNC."""
