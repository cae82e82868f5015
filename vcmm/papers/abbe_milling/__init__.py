"""Abbe-consistent volumetric errors of milling: spline slots in two models."""
