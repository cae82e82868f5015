"""What is handed over: documentation, wheel, sdist, long fuzz. Part of `make test-all`."""
