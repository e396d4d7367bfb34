"""A dump that is waited for by what it is, and one that is held between two pieces: nothing here
depends on how fast the machine is.
"""

from __future__ import annotations

from mikas.dashboard.session import dump_jobs

XRAM = {"space": "xram", "first": 0x100, "last": 0x8FF}


def when(it, name, accepted):
    """The dump as soon as it is so; looked at with each live message."""
    with it.live() as live:
        for _ in range(2000):
            if accepted(dump := it.get(f"/dumps/{name}")):
                return dump
            live.next()
    raise AssertionError(f"it never came; {dump}")


def ended(it, name, *phases):
    return when(it, name, lambda dump: dump["state"] in phases)


def until_read(it, name, least=1):
    dump = when(it, name, lambda dump: dump["done"] >= least or dump["state"] != "running")
    assert dump["done"] >= least, dump
    return dump


def hold(monkeypatch):
    """From here on a dump stops behind each piece until it is paused and resumed."""
    monkeypatch.setattr(dump_jobs, "TURN", 3600)


def let_go(monkeypatch, it, name):
    """The dump goes on, to its end."""
    monkeypatch.setattr(dump_jobs, "TURN", 0)
    it.post(f"/dumps/{name}/pause")
    return it.post(f"/dumps/{name}/resume")
