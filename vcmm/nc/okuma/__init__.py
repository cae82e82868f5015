"""Okuma OSP programs.

Imports nc, nc.iso.
"""
