"""What measured data say of the true values: points and values taken in, the inverse of extreme values, the audit.

Imports core, fit, part, gps, measuring, response, evaluation.
"""
