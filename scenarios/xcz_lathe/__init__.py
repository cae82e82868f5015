"""On-machine measurement on an ultra-precision X-C-Z lathe: reversals, selective error model, map, a flat compensated."""
