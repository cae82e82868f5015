"""Pages in a real browser: part of `make test-all`."""
