"""All that the program offers, as tables that the desktop and the page without installation share.

`routes.py`: every route of the API, in an order in which each has what it needs. `screens.py`:
what a person does on each screen. A fault of one home alone, a module that its Python lacks, shows
in the other's absence of it. `tests/browser` and `tests/static_site` drive both tables.
"""
