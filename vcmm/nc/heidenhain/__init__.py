"""HEIDENHAIN Klartext programs.

Imports core, nc.
"""
