"""NC programs: what they mean, how long they take, and how they are rewritten."""
