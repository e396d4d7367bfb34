"""Routes of kept files: recordings, their exports and reports, dumps."""
