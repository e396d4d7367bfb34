"""Check the locked packages against the known advisories: `make audit`.

pip-audit and npm audit ask their registries' services. Where these can't be reached, the output
says so and names the date of the last look by hand (advisories.toml, which
tests/test_requirements.py checks). Exit status 1: a locked package has a known advisory.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Final

HERE: Final = Path(__file__).parent
_SECONDS: Final = "30"
_PIP_AUDIT: Final = (
    sys.executable, "-m", "pip_audit", "--disable-pip", "--require-hashes", "--format=json",
    "--progress-spinner=off", "--timeout", _SECONDS, "--requirement", str(HERE / "lock.txt"),
)  # fmt: skip
_NPM_AUDIT: Final = ("npm", "audit", "--json", "--prefix", str(HERE.parent / "web"))

# The output of a program that was started with these arguments; its exit status says less.
Runner = Callable[[Sequence[str]], str]


def main(run: Runner | None = None) -> int:
    """Print what was found; return the exit status."""
    run = run or _output
    searched = tomllib.loads((HERE / "advisories.toml").read_text(encoding="utf-8"))["searched"]
    found: list[str] = []
    for name, command, read in (
        ("pip-audit", _PIP_AUDIT, _of_pip_audit),
        ("npm audit", _NPM_AUDIT, _of_npm_audit),
    ):
        advisories = read(run(command))
        if advisories is None:
            print(f"{name}: its service can't be reached. Last look by hand: {searched}")
        elif advisories:
            found += advisories
        else:
            print(f"{name}: no known advisory")
    for line in found:
        print(line, file=sys.stderr)
    if found:
        print("Newer versions: make lock UPGRADE=--upgrade; npm audit fix", file=sys.stderr)
    return 1 if found else 0


def _of_pip_audit(output: str) -> list[str] | None:
    """Return a line for each advisory; None if nothing was audited."""
    packages = _json(output).get("dependencies", [])
    audited = [package for package in packages if "vulns" in package]
    if not audited:
        return None
    lines = [
        f"{package['name']} {package['version']}: {known['id']}, "
        f"fixed in {', '.join(known['fix_versions']) or 'no version'}"
        for package in audited
        for known in package["vulns"]
    ]
    missed = [package["name"] for package in packages if "vulns" not in package]
    return lines + [f"{name}: not audited" for name in missed]


def _of_npm_audit(output: str) -> list[str] | None:
    """Return a line for each package with an advisory; None if nothing was audited."""
    found = _json(output).get("vulnerabilities")
    if found is None:
        return None
    return [f"{name}: {known['severity']}, {known['range']}" for name, known in found.items()]


def _json(output: str) -> dict[str, Any]:
    try:
        answer = json.loads(output)
    except ValueError:
        return {}
    return answer if isinstance(answer, dict) else {}


def _output(command: Sequence[str]) -> str:
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=False)
    return done.stdout


if __name__ == "__main__":
    sys.exit(main())
