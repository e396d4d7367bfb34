"""The parts of the page: their sentences, rows and tables, a module for each."""
