"""From an instrument's readings to a machine: identification, what could not be identified, design, standard figures.

Imports core, effects, response, instruments, files, diagnosis.
"""
