"""The command line (docs/reference/cli.md is its contract)."""
