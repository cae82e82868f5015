"""Learn from recordings: calibration, diagnosis and tracking of machines."""
