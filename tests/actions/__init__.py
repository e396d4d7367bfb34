"""All that the program offers, as tables that the desktop and the page without installation share.

`routes.py`: every route of the API, in an order in which each has what it needs. `screens.py`:
what a person does on the screens, of the rows in `on_….py`, whose steps are those of `steps.py`;
`controls.py` finds in the page's sources what can be pressed, and a test misses what no row does.
A fault of one home alone, a module that its Python lacks, shows in the other's absence of it.
`tests/browser` and `tests/static_site` drive both tables.
"""
