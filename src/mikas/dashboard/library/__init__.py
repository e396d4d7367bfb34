"""The files that are kept: the folder of recordings, open recordings, deletion in two steps."""
