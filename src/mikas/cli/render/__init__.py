"""Values, tables, notices and JSON on a terminal or in a pipe."""
