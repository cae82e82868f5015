"""Geometrical product specification: values of characteristics, and decisions about them (lazy: import the
modules).
"""
