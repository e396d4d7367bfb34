"""A real shell on a pty, in which a line is typed and completed by the Tab key."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).parents[3]
_BEGIN = {
    "bash": r"""
PS1='> '; bind 'set show-all-if-ambiguous on' 'set bell-style none' 'set page-completions off'
bind 'set completion-query-items 0' 'set enable-bracketed-paste off'
""",
    "zsh": r"""
PS1='> '; bindkey -e; unset zle_bracketed_paste; LISTMAX=9999; setopt no_beep no_prompt_sp
autoload -Uz compinit; compinit -u -D
""",
}
_COMMAND = {"bash": ["bash", "--norc", "--noprofile", "-i"], "zsh": ["zsh", "-f", "-i"]}
_SECONDS = 300  # at most


class Shell:
    """`bash` or `zsh`, with the program's script, in `folder`."""

    def __init__(self, name: str, folder: Path, program: Path) -> None:
        environment = {
            "PATH": f"{program.parent}:{os.environ['PATH']}", "HOME": str(folder), "TERM": "dumb",
            "LC_ALL": "C.UTF-8", "PYTHONPATH": str(ROOT / "src"), "INPUTRC": "/dev/null",
            "MIKAS_LANG": "en", "COLUMNS": "200",
        }  # fmt: skip
        ours, theirs = pty.openpty()
        self._pty = ours
        self._process = subprocess.Popen(
            _COMMAND[name], stdin=theirs, stdout=theirs, stderr=theirs, cwd=folder,
            env=environment, start_new_session=True,
        )  # fmt: skip
        os.close(theirs)
        begin = folder / f"begin.{name}"
        begin.write_text(_BEGIN[name] + f'eval "$(mikas completion {name})"\n', "utf-8")
        self._run(f". ./{begin.name}")

    def complete(self, line: str) -> tuple[str, str]:
        """Type `line` and Tab; return the line that it becomes, and all that is shown."""
        shown = self._run(line + "\t", before="echo '<'", after="'>'")
        (became,) = re.findall(r"^< ?(.*?) ?>\r?$", shown, re.MULTILINE)[-1:] or [""]
        return became, shown

    def _run(self, typed: str, before: str = "", after: str = "") -> str:
        """Type, then let the line be run, which writes a mark; return all up to it."""
        # Ctrl-A, Ctrl-E: to the begin and the end of the line, once Tab has done its work.
        line = f"{typed}\x01{before} \x05 {after}; echo do''ne\n"
        os.write(self._pty, line.encode())
        shown, end = b"", time.monotonic() + _SECONDS
        while not re.search(rb"\ndone\r?\n", shown):
            ready, _, _ = select.select([self._pty], [], [], max(0.0, end - time.monotonic()))
            if not ready:
                raise AssertionError(f"no end: {shown.decode(errors='replace')}")
            shown += os.read(self._pty, 1 << 16)
        return shown.decode(errors="replace")

    def close(self) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._pty)


def program(folder: Path) -> Path:
    """Return the path of a `mikas` that runs the sources that are tested."""
    path = folder / "bin" / "mikas"
    path.parent.mkdir()
    path.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m mikas "$@"\n', "utf-8")
    path.chmod(0o755)
    return path
