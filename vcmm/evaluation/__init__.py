"""Uncertainty of a task: streams, intervals, Monte Carlo, linear and exact model, budget, certificate.

Imports core, fit, part, gps, effects, charts, measuring, response, certified.
"""
