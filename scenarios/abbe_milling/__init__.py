"""Abbe-consistent volumetric errors: slots milled under two models of the same machine."""
