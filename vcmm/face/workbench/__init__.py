"""The page of a task, live on this machine: knobs in a browser, and U, decision and budget moving with them."""
