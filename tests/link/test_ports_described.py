"""What is behind a URL, in the reader's language."""

from __future__ import annotations

from mikas.link import open_link
from mikas.link.ports import described


def test_a_virtual_unit_has_a_name_in_each_language() -> None:
    with open_link("sim:?clock=simulated") as link:
        assert link.description == "virtual ECU"
        assert described(link.description) == ("virtual ECU", "виртуальный блок")


def test_a_product_is_called_what_it_is_called() -> None:
    name = "FT232R USB UART (FTDI)"
    assert described(name) == (name, name)
    assert described("") == ("", "")
