"""The site's program without docstrings: all else as it was, line by line."""

from __future__ import annotations

import ast
import json
import subprocess
import sys

from tools.site.docstrings import without_docstrings

from tools.site import packages

SOURCE = b'''"""A module."""
from __future__ import annotations

class Car:
    """A car.

    It has \xd1\x91.
    """

    def start(self):
        """Start."""

    async def stop(self):
        """Stop
        it."""; return "stopped"
'''
DESCRIBED = """
import json
from mikas.dashboard.app import openapi_description
print(json.dumps(openapi_description()))
"""


def test_a_module_loses_its_docstrings_and_keeps_its_lines():
    bare = without_docstrings({"mikas/car.py": SOURCE, "mikas/car.toml": b'"""no"""'})
    assert bare["mikas/car.toml"] == b'"""no"""'
    assert bare["mikas/car.py"].decode().split("\n") == [
        '""', "from __future__ import annotations", "", "class Car:", '    "."', "", "", "", "",
        "    def start(self):", "        0", "", "    async def stop(self):",
        "        0", '; return "stopped"', "",
    ]  # fmt: skip


def test_every_module_is_the_same_but_for_them():
    own = packages.own()
    for name, content in without_docstrings(own).items():
        if name.endswith(".py"):
            assert shape(content) == shape(own[name]), name


def shape(source: bytes) -> list[tuple[int, str]]:
    """Each statement that is no text, by its line."""
    return [
        (node.lineno, type(node).__name__)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.stmt) and not isinstance(node, ast.Expr)
    ]


def test_the_description_of_the_api_stays(tmp_path):
    for name, content in without_docstrings(packages.own()).items():
        file = tmp_path / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(content)
    assert described(tmp_path) == described(packages.ROOT / "src")


def described(folder):
    code = f"import sys; sys.path.insert(0, {str(folder)!r}){DESCRIBED}"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)
