"""The part before it is cut: program, machine and set-up to deviations of features with their uncertainty."""
