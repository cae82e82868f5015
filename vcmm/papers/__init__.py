"""The founding papers: each a twin with its page and its command in one folder."""
