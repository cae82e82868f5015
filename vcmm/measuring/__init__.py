"""The measuring task: plan, strategies, contact, qualification, fixture, scenario.

Imports core, fit, part, gps, effects, charts.
"""
