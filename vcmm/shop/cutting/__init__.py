"""Simulate the cut: swept envelopes, contact map, stock, forces. Part frame, mm; s > 0 is material left."""
