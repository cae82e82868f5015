"""What a run shows of every error: influences, observations, nuisances, logs. One home for the columns of G."""
