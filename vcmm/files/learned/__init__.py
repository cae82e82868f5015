"""What was learned, as files: machines that calibration, diagnosis and tracking write, and folders of recordings that they read."""
