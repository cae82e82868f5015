"""From the readings of instruments to a machine file with honest covariance."""
