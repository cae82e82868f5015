"""Evaluate characteristics of a drawing and decide about conformity."""
