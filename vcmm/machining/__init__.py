"""The part before it is cut: program, machine and set-up to deviations of features with their uncertainty.

Imports core, fit, part, gps, effects, charts, nc, motion, cutting, measuring, response, evaluation, placing.
"""
