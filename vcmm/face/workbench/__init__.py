"""The page of a task, live on this machine: knobs in a browser, with U, decision and budget following them."""
