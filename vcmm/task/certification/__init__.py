"""Machines of which only a certificate is known: drawn so that they pass the acceptance test that it states."""
