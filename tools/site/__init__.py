"""Builds the page without installation: the dashboard and its Python program as static files.

`make site` runs `python -m tools.site`; `make page` runs `python -m tools.site.serve`.

    packages     the packages of requirements/lock.txt that the program imports, and mikas itself
    stdlib       Python's standard library, without what a browser can't use
    compiling    bytecode, by the Python that will run it
    pyodide      that Python, under Node; in_pyodide is what it runs here
    archives     archives whose bytes depend on nothing but their contents
    licences     the texts that have to come with the packages
    listing      files.json: names, sizes and hashes of all files
"""
