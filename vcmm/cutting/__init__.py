"""Virtual cutting: swept envelopes of tools, the contact map, the stock, forces. Part frame, mm; s > 0 = material left."""
