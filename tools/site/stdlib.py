"""Python's standard library, without what a browser tab can't use or nobody there asks for."""

from __future__ import annotations

import re
from collections.abc import Mapping

# Modules, packages, and paths in packages.
_UNUSED = frozenset(
    """
    _pyrepl asyncio/__main__ asyncio/proactor_events asyncio/windows_events asyncio/windows_utils
    cmd concurrent/futures/process concurrent/interpreters curses fileinput ftplib http/cookiejar
    http/server imaplib logging/config logging/handlers mailbox multiprocessing netrc poplib pty
    pyodide/console pwd rlcompleter smtplib socketserver tty webbrowser wsgiref xmlrpc

    __hello__ __phello__ antigravity bdb cProfile compileall doctest filecmp idlelib modulefinder
    optparse pdb pickletools profile pstats py_compile pyclbr pydoc symtable tabnanny this timeit
    trace unittest zipapp

    compression/lzma ctypes/macholib dbm lzma mailcap nturl2path plistlib shelve sqlite3 wave
    xml/dom xml/etree xml/parsers

    _pydatetime _pydecimal _pyio importlib/_bootstrap importlib/_bootstrap_external
    """.split()  # noqa: SIM905 (four groups, which a list would spread over eighty lines)
)
"""Other processes, terminals and servers; tools of developers; data and formats that the program
does not read; what the interpreter has in C or in itself.
"""
# Recordings, lists and exports are UTF-8 or Windows-1251; archives name their files in cp437.
_ENCODINGS = re.compile(
    r"encodings/(__init__|aliases|ascii|base64_codec|charmap|cp437|cp866|cp1251|cp1252|hex_codec|"
    r"idna|iso8859_1|latin_1|punycode|raw_unicode_escape|undefined|unicode_escape|utf_\w+)\.py"
)


def needed(library: Mapping[str, bytes]) -> dict[str, bytes]:
    """Return the files of `library`, an unpacked python_stdlib.zip, that belong into the site."""
    return {name: content for name, content in library.items() if _is_needed(name)}


def _is_needed(name: str) -> bool:
    if name.startswith("encodings/"):
        return _ENCODINGS.fullmatch(name) is not None
    module = name.removesuffix(".py")
    parents = (module[:end] for end, letter in enumerate(module) if letter == "/")
    return module != name and _UNUSED.isdisjoint((module, *parents))
