"""Readers of HEIDENHAIN Klartext programs."""
