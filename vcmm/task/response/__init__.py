"""The columns of G: what every error does to every observation of a run, a recording or a task."""
