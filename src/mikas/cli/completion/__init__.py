"""Completion in the shell: commands, options, and the values of each.

`mikas completion SHELL` prints the script of a shell (`scripts/`). It asks this program by the
environment: `_MIKAS_COMPLETE=bash_complete`, with the line (bash) or its words, one a line, up to
the cursor. The answer has a line for each offer: its kind, the whole word, a description, with tabs
between. An error is no answer; a message would be in the way in the middle of a line.
"""

from mikas.cli.completion.answering import VARIABLE, answer, is_asked
from mikas.cli.completion.scripts import SHELLS, script

__all__ = ["SHELLS", "VARIABLE", "answer", "is_asked", "script"]
