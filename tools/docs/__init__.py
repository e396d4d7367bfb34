"""Builds the documentation site: docs/** and what is generated from the program, in two languages.

`make docs` runs `python -m tools.docs`; `make check` runs `python -m tools.docs.check`.

    navigation   the pages of the site, their order and titles
    waiting      pages whose text or translation is still to come
    markdown     what a Markdown file consists of: headings, blocks of code, links
    pages        which file is which page, in each language
    generated    pages and drawings that are made from the program
    dialect      Markdown as the web shows it, as Python-Markdown wants it
    assembling   one language's pages, with links that lead somewhere on the site
    rendering    Zensical over them
    offline      what a browser would load from elsewhere
    checking     the rules of `make check`; a finding is a line of its output
"""
