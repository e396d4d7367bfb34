"""What the campaigns that make their own cases have in common: how they are called."""

from __future__ import annotations

import argparse


def campaign_parser(target: str, seconds: float) -> argparse.ArgumentParser:
    """Return the parser of `python -m fuzz.TARGET.campaign`; it lasts `seconds` by default."""
    parser = argparse.ArgumentParser(prog=f"python -m fuzz.{target}.campaign")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=seconds)
    parser.add_argument("--cases", type=int, default=1 << 40, help="at most so many")
    return parser
