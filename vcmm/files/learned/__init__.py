"""Files of what was learned: machines that calibration, diagnosis and tracking write, and folders of recordings that they read."""
