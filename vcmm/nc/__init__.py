"""NC programs: what they mean, in the words that all controls share. Imports core; never a reader of one control."""
