"""A question to a dataset: the database, what may be asked, and the files that it may read."""
