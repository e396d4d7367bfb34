"""What `make bench` measures: a module a theme, whose tables are made by its run()."""
