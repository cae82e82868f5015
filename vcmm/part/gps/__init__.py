"""Characteristics of a drawing, and the decisions about them."""
