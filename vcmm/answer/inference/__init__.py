"""Infer true values from measured data: points and values of parts, and the audit of the intervals."""
