"""Parameters, derived channels, faults, models and errata as data (§4).

    raw bytes ── Parameter.decode ──► value        Catalog.fault(13), .model(0x0A), .errata["E1"]
    raw bytes ◄── Parameter.encode ── value        Catalog.parameter("TWAT"), .size_of(0x1A)
    values ── Derived.calculation() ──► value      Catalog.derived["FUEL_USED"], .channel(name)

`shipped()` has the `.toml` files of this folder; `load(file, …)` overrides them by a user's files.
"""

from mikas.catalog.conversion import Conversion
from mikas.catalog.instrument_channels import InstrumentChannel
from mikas.catalog.limits import AlarmLimits, Confidence, Level
from mikas.catalog.loading.loader import load, shipped
from mikas.catalog.lookup import Catalog
from mikas.catalog.model import (
    INTERPRETATIONS,
    Derived,
    Erratum,
    Fault,
    Interpretation,
    Lamp,
    Meaning,
    Model,
    Parameter,
)

__all__ = [
    "INTERPRETATIONS",
    "AlarmLimits",
    "Catalog",
    "Confidence",
    "Conversion",
    "Derived",
    "Erratum",
    "Fault",
    "InstrumentChannel",
    "Interpretation",
    "Lamp",
    "Level",
    "Meaning",
    "Model",
    "Parameter",
    "load",
    "shipped",
]
