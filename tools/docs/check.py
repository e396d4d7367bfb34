"""python -m tools.docs.check: fails on a stale link, example or translation of the documents.

The site is checked too, as it was built by `make docs`; documents are checked side by side.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path, PurePosixPath

from tools.docs.__main__ import BUILT
from tools.docs.checking import built, citations, examples, links, named, structure, typed
from tools.docs.checking.finding import Finding
from tools.docs.generated.writing import files as generated
from tools.docs.pages import LANGUAGES, ROOT, files

OTHERS = (
    "CONTRIBUTING.md", "README.md", "SECURITY.md", "conformance/README.md", "examples/README.md",
    "fuzz/README.md",
)  # fmt: skip


def main() -> int:
    """Print all findings; return the exit status."""
    documents = [PurePosixPath(name) for name in OTHERS]
    documents += [file for language in LANGUAGES for file in files(language)]
    with tempfile.TemporaryDirectory() as folder, ProcessPoolExecutor() as side_by_side:
        drive = Path(folder) / examples.RECORDING
        side_by_side.submit(examples.recording, drive).result()
        ran = side_by_side.map(partial(examples.findings, drive=drive), documents)
        found: list[Finding] = [*structure.findings(), *stale(), *built.findings(BUILT)]
        found += typed.findings()
        for file in documents:
            found += [*links.findings(file), *named.findings(file), *citations.findings(file)]
        for each in ran:
            found += each
    for finding in found:
        print(finding)
    if not (BUILT / "index.html").is_file():
        print("build/docs was not built: make docs")
        return 1
    print(f"{len(documents)} documents checked: {len(found) or 'no'} findings")
    return 1 if found else 0


def stale() -> Iterator[Finding]:
    """Yield the generated files of the repository that are not what the program is now."""
    for file, text in generated():
        path = ROOT / file
        if not path.is_file() or path.read_text("utf-8") != text:
            yield Finding(file, 1, "is stale: python -m tools.docs.generated")


if __name__ == "__main__":
    sys.exit(main())
