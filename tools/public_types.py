"""python -m tools.public_types: how much of the library's types a type checker knows (pyright).

The public interface is what the reference has pages of (tools/docs/generated/python_pages.py): all
of its names have types that no checker infers its own way. All other modules are private; pyright,
which takes each name without an underscore for public, counts them too.
"""

from __future__ import annotations

import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Final

from tools.docs.generated.python_pages import PAGES
from tools.pyright import PyrightFailed, report

LEAST: Final = 0.98


@dataclass(frozen=True, slots=True)
class Completeness:
    """The share of all names whose types are known, and the public names whose types are not."""

    share: float
    unknown: tuple[str, ...]

    @property
    def suffices(self) -> bool:
        """Whether it is as good as it has to be."""
        return self.share >= LEAST and not self.unknown


def public_names() -> frozenset[str]:
    """Return the full name of each public name, at its definition and where it is exported."""
    found = set()
    for page in PAGES:
        for name in page.names:
            found.add(f"{name.module}.{name.name}")
            defined = getattr(name.value, "__module__", name.module)
            found.add(f"{defined}.{getattr(name.value, '__qualname__', name.name)}")
    return frozenset(found)


def completeness(symbols: Iterable[Mapping[str, Any]], public: Collection[str]) -> Completeness:
    """Return what pyright's `symbols` say of all exported names, and of the `public` ones."""
    exported = [each for each in symbols if each["isExported"] and _is_shipped(each["name"])]
    unknown = [each["name"] for each in exported if not _is_known(each)]
    share = 1 - len(unknown) / len(exported) if exported else 0.0
    return Completeness(share, tuple(sorted(name for name in unknown if _is_of(name, public))))


def causes(symbols: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the names that are unknown by themselves, not by what they are made of."""
    for symbol in symbols:
        if not _is_shipped(symbol["name"]):
            continue
        for each in symbol["diagnostics"]:
            if "partially unknown" not in each["message"] and not _is_known(symbol):
                yield f"{symbol['name']}: {' '.join(each['message'].split())}"
                break


def _is_shipped(name: str) -> bool:
    """Return whether the wheel has it: the page without installation has a room of its own."""
    return not name.startswith("mikas.browser.")


def _is_known(symbol: Mapping[str, Any]) -> bool:
    return symbol["isTypeKnown"] and not symbol["isTypeAmbiguous"]


def _is_of(name: str, public: Collection[str]) -> bool:
    """Return whether it is a public name, or a member of one."""
    parts = name.split(".")
    is_private = any(part.startswith("_") and not part.startswith("__") for part in parts)
    return not is_private and any(".".join(parts[:n]) in public for n in range(2, len(parts) + 1))


def main() -> int:
    """Measure and print; return the exit status."""
    try:
        found_all = report("--ignoreexternal", "--verifytypes", "mikas")
        symbols = found_all["typeCompleteness"]["symbols"]
    except PyrightFailed as error:
        print(error)
        return 2
    except KeyError:
        print(f"pyright did not say what it found: {found_all}")
        return 2
    if not symbols:
        print("pyright has found no names")
        return 2
    found = completeness(symbols, public_names())
    print(f"types known: {found.share:.1%} of all names, at least {LEAST:.0%}")
    if not found.suffices:
        print(f"public names whose types are not known: {len(found.unknown)}; the causes:")
        print(*causes(symbols), sep="\n")
    return 0 if found.suffices else 1


if __name__ == "__main__":
    sys.exit(main())
