"""A session as a table: `Session.to_pandas`."""

from __future__ import annotations

import pytest

import mikas
from mikas.sampling.events import Sampled

pytest.importorskip("pandas")
SIM = "sim:?clock=simulated"


def test_a_table_has_times_and_missing_values():
    with mikas.session(SIM, ["FREQ", "TWAT/10", "FUEL_FLOW"], method="batch") as session:
        table = session.to_pandas(5)
    assert list(table.columns) == ["FREQ", "TWAT", "FUEL_FLOW"]
    assert str(table.index.tz) == "UTC"
    assert table["FREQ"].notna().all()
    assert table["TWAT"].isna().any()


def test_a_table_has_no_jump_where_the_date_was_set():
    """All times of a session are to be read by as much later, also those before."""
    session = mikas.session(SIM, ["FREQ"], method="batch", count=20)
    taken = []

    def set_the_date(sample):
        taken.append(sample.time)
        if len(taken) == 10:
            session.sampling.later = 3600.0

    session.on(Sampled, set_the_date)
    with session:
        table = session.to_pandas()
    assert table.index[0].timestamp() == pytest.approx(taken[0] + 3600)
    assert (table.index[-1] - table.index[0]).total_seconds() < 10
