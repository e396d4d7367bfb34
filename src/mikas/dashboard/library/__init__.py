"""The files that are kept: the folder of recordings, open recordings, references."""
