"""The founding papers, each as a twin with its page and its command. Imports every job; only the command line imports it."""
