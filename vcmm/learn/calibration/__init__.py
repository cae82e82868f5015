"""Calibrate: from readings of instruments to a machine file with its joint covariance."""
