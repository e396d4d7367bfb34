"""mikas in a browser tab: the whole program on Pyodide, in a worker of the page (docs/browser.md).

Nothing else of mikas imports this package, and the product's wheel leaves it out. What differs in a
browser is handed in here: threads, the event loop, ports, folders, arrays.
"""
