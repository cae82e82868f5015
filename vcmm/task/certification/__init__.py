"""Machines known by a certificate only: sampled so that they pass the acceptance test that it states."""
