"""From the readings of instruments to a machine file with honest covariance.

Imports core, effects, charts, response, certified, instruments, files, diagnosis.
"""
