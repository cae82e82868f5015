"""From recordings to effects: calibration and diagnosis."""
