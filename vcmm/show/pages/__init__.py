"""The page of every job, put together from the blocks of report."""
