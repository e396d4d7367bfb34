"""Read catalog files (§4): source (TOML, lines) → entries (merged, by fields) → build → loader."""
