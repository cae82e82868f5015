"""Simulate the part before it is cut: from program, machine and set-up to deviations of features with their uncertainty."""
