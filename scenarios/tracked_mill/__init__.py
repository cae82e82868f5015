"""A CMM read by a LaserTracer at several stations, warming up: the recordings of the scenario, drawn."""
