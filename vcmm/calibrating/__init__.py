"""From the readings of instruments to a machine file with honest covariance.

Imports core, effects, charts, measuring, response, certified, instruments, evaluation, files, diagnosis.
"""
