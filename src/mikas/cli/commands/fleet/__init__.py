"""Commands on many recordings as one dataset. None of them needs a port."""
