"""Okuma OSP programs."""
