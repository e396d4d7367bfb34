"""A computer on which something is installed and started: no network, no Python and no Node on its
path, an empty environment and an empty home folder.

Its network is a namespace that has only 127.0.0.1. Root makes it as it is; another user needs user
namespaces (`unshare --map-root-user`), which most systems allow.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from tools.package.trial import Trial

ROOT = Path(__file__).resolve().parents[2]
DIST = ROOT / "dist"


def built(pattern):
    """The one file of dist/ with such a name."""
    found = list(DIST.glob(pattern))
    assert len(found) == 1, f"{pattern} in dist/: {found}; `make package` builds them"
    return found[0]


class Computer:
    """`home`: the user's folder; `path`: the folders of programs, none by default."""

    def __init__(self, home, path=()):
        self.home, self.path = Path(home), [str(each) for each in path]
        self.environment = {}

    def __enter__(self):
        user = [] if os.geteuid() == 0 else ["--map-root-user"]
        self._holder = subprocess.Popen(
            ["unshare", "--net", *user, "sh", "-c", "ip link set lo up && echo up && exec cat"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={"PATH": "/usr/bin:/bin:/usr/sbin:/sbin"},
        )
        assert self._holder.stdout.readline() == b"up\n", (
            "this system keeps namespaces from users; on Ubuntu: "
            "sudo sysctl kernel.apparmor_restrict_unprivileged_userns=0, or run this as root"
        )
        return self

    def __exit__(self, *_):
        self._holder.communicate()

    @property
    def variables(self):
        """The whole environment of a program there."""
        return {"HOME": str(self.home), "PATH": ":".join(self.path), "LC_ALL": "C.UTF-8"} | {
            name: str(value) for name, value in self.environment.items()
        }

    def command(self, *words):
        """The command line that runs `words` there."""
        user = [] if os.geteuid() == 0 else ["--user", "--preserve-credentials"]
        enter = ["nsenter", f"--target={self._holder.pid}", "--net", *user]
        given = [f"{name}={value}" for name, value in self.variables.items()]
        return [*enter, "env", "-i", "--chdir", str(self.home), *given, *map(str, words)]

    def run(self, *words, status=0):
        """Run a command to its end; what it wrote."""
        done = subprocess.run(
            self.command(*words),
            capture_output=True,
            encoding="utf-8",
            stdin=subprocess.DEVNULL,
            check=False,
        )
        assert done.returncode == status, f"{words}\n{done.stdout}{done.stderr}"
        return done

    def trial(self, program):
        """What the program has to do, tried there."""
        return Trial(program, self.home, self.command())

    def has(self, program):
        """Whether a shell would find `program`."""
        return shutil.which(program, path=":".join(self.path)) is not None
