"""A ball bar on a mill: the recording of the scenario, drawn."""
