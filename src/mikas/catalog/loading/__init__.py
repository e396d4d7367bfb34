"""Read catalog files: TOML with its lines, entries laid over each other, checked values (§4).

source ──► entries ──► fields ──► build, derived, limits, texts ──► loader: a Catalog
"""
