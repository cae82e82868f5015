"""The columns of G: the response of every observation of a run, a recording or a task to every error."""
