"""Execute the example notebooks in a real kernel; as a program, write them with their results.

    .venv/bin/python tests/notebooks/execute.py

The results are in the repository, so that GitHub shows them. Pictures depend on matplotlib and its
fonts, so of them only the presence is compared; texts are the same wherever they are made.
"""

from __future__ import annotations

import base64
import io
import os
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

import nbformat
from nbclient import NotebookClient
from nbformat import NotebookNode
from PIL import Image

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples" / "notebooks").glob("*.ipynb"))
PNG = "image/png"


def executed(path: Path) -> NotebookNode:
    """Return the notebook with the results of all its cells. Raises what a cell raises."""
    notebook = nbformat.read(path, as_version=4)
    with TemporaryDirectory(prefix="mikas-notebook-") as folder:
        settings = {
            "MIKAS_LANG": "en",
            "MIKAS_STATE": str(Path(folder) / "state"),
            "MIKAS_CONFIG": str(Path(folder) / "config.toml"),
            "PYDEVD_DISABLE_FILE_VALIDATION": "1",
        }
        with patch.dict(os.environ, settings):
            resources = {"metadata": {"path": folder}}
            client = NotebookClient(
                notebook, kernel_name="python3", timeout=300, resources=resources,
                record_timing=False,
            )  # fmt: skip
            client.execute()
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    return notebook


def results(notebook: NotebookNode) -> list[tuple[str, ...]]:
    """Return of each result its cell, its kinds, and its text unless it is a picture."""
    found = []
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            text = "" if PNG in data else output.get("text") or data.get("text/plain", "")
            kinds = ",".join(sorted(data))
            found.append((cell.id, output.output_type, output.get("name", ""), kinds, text))
    return found


def _with_smaller_pictures(notebook: NotebookNode) -> NotebookNode:
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            if PNG in (data := output.get("data", {})):
                picture = Image.open(io.BytesIO(base64.b64decode(data[PNG])))
                file = io.BytesIO()
                picture.convert("RGB").quantize(64).save(file, "PNG", optimize=True)
                data[PNG] = base64.b64encode(file.getvalue()).decode()
    return notebook


def main() -> None:
    for path in NOTEBOOKS:
        notebook = _with_smaller_pictures(executed(path))
        path.write_text(nbformat.writes(notebook).rstrip("\n") + "\n", "utf-8")


if __name__ == "__main__":
    main()
