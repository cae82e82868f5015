"""Files that people have, read and written: machines, scenarios, recordings, tables of other programs."""
