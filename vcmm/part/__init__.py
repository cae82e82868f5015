"""The part: features in the drawing frame, mesh, form, alignment.

Imports core, fit.
"""
