"""What is to be sampled, and through what: kept while nothing is connected too."""

from __future__ import annotations

from dataclasses import dataclass

from mikas.client.polling import FixedMethod


@dataclass(frozen=True, slots=True)
class Wish:
    """What is to be sampled, and how: by the channel's name, in every how manieth cycle."""

    every: dict[str, int]
    method: FixedMethod | None = None
    rate: float | None = None

    @property
    def names(self) -> list[str]:
        """As `Acquisition` takes them: `TWAT/10`."""
        return [name if every == 1 else f"{name}/{every}" for name, every in self.every.items()]


@dataclass(frozen=True, slots=True)
class Way:
    """How the unit is reached."""

    url: str
    echo: str = "auto"
