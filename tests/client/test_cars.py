"""The details of a car: kept by unit, in the recording, on the report; bounded and cleaned."""

from __future__ import annotations

import json

import pytest

from mikas.client.cars import LONGEST, NO_CAR, CarBook, CarDetails, car_details
from mikas.client.identity import Passport, UnitIdentity
from mikas.errors import UsageError
from mikas.recording.annotations.events import car_note, car_of
from mikas.recording.capture.notes import Kind, Note
from mikas.virtual import VIRTUAL_PASSPORT

VOLGA = CarDetails("Волга 3110", "А123ВС 52", 154_000, "Гараж")


def unit(version_code, *pieces):
    return UnitIdentity(version_code, Passport(pieces, ()))


def test_kept_by_unit_and_the_workshop_for_all(tmp_path) -> None:
    book = CarBook(tmp_path / "state" / "cars.json")
    assert book.details_of(unit(10, "A")) is None
    book.keep(unit(10, "A"), VOLGA)
    book.keep(unit(10, "B"), CarDetails(workshop="Гараж"))
    again = CarBook(tmp_path / "state" / "cars.json")
    assert again.details_of(unit(10, "A")) == VOLGA
    assert again.details_of(unit(10, "B")) == CarDetails(workshop="Гараж")  # put off, but asked
    assert again.details_of(unit(9, "A")) is None
    book.keep(unit(10, "A"), CarDetails("Волга", "", None, "Сервис"))
    assert again.details_of(unit(10, "A")) == CarDetails("Волга", "", 154_000, "Сервис")
    assert again.details_of(unit(10, "B")) == CarDetails(workshop="Сервис")


def test_what_can_not_be_saved_stays_as_long_as_the_book(tmp_path) -> None:
    (tmp_path / "state").write_text("in the place of the folder")
    book = CarBook(tmp_path / "state" / "cars.json")
    for name in "AB":
        with pytest.raises(UsageError, match=r"cars\.json"):
            book.keep(unit(10, name), VOLGA)
    assert [book.details_of(unit(10, name)) for name in "ABC"] == [VOLGA, VOLGA, None]
    (tmp_path / "state").unlink()
    book.keep(unit(10, "C"), CarDetails("Волга"))
    again = CarBook(tmp_path / "state" / "cars.json")
    assert [again.details_of(unit(10, name)).car for name in "ABC"] == [
        "Волга 3110", "Волга 3110", "Волга",
    ]  # fmt: skip


def test_a_unit_with_empty_passports_has_no_car(tmp_path) -> None:
    book = CarBook(tmp_path / "cars.json")
    book.keep(unit(10, "", ""), VOLGA)
    book.keep(unit(None, "A"), VOLGA)
    assert book.details_of(unit(10, "", "")) is None
    assert book.details_of(unit(None, "A")) is None
    assert book.workshop == "Гараж"


@pytest.mark.parametrize(
    "stored", ["", "[]", "{}", '{"cars": 3}', '{"cars": {"x": 1}, "workshop": 7}', "[" * 5000]
)
def test_a_file_that_can_not_be_used_has_no_cars(tmp_path, stored) -> None:
    (tmp_path / "cars.json").write_text(stored)
    book = CarBook(tmp_path / "cars.json")
    assert (book.details_of(unit(10, "A")), book.workshop) == (None, "")
    book.keep(unit(10, "A"), VOLGA)
    assert book.details_of(unit(10, "A")) == VOLGA


def test_the_book_is_bounded(tmp_path) -> None:
    file = tmp_path / "cars.json"
    cars = {f"{number:016x}": {"car": str(number)} for number in range(600)}
    file.write_text(json.dumps({"cars": cars}))
    book = CarBook(file)
    book.keep(unit(10, "A"), VOLGA)
    assert len(json.loads(file.read_text("utf-8"))["cars"]) == 500
    assert book.details_of(unit(10, "A")) == VOLGA


@pytest.mark.parametrize(
    ("data", "details"),
    [
        (None, NO_CAR),
        ({"car": 1, "plate": None, "mileage": True, "workshop": []}, NO_CAR),
        ({"mileage": -1}, NO_CAR),
        ({"mileage": 10_000_000}, NO_CAR),
        ({"mileage": 1.5}, NO_CAR),
        ({"car": " a\nb\x1b[2J "}, CarDetails("a b�[2J")),
        ({"plate": "x" * 999, "mileage": 0}, CarDetails(plate="x" * LONGEST, mileage=0)),
    ],
)
def test_details_of_a_car_from_outside_are_cleaned_and_bounded(data, details) -> None:
    assert car_details(data) == details


def test_the_last_note_counts() -> None:
    notes = [car_note(1.0, VOLGA), Note(Kind.MARKER, 2.0), car_note(3.0, NO_CAR)]
    assert car_of(notes[:2]) == VOLGA
    assert car_of(notes) == NO_CAR
    assert not NO_CAR
    assert CarDetails(mileage=0)
    assert VOLGA.name == "Волга 3110 · А123ВС 52"


def test_nothing_is_kept_of_a_virtual_unit_unless_asked_for(tmp_path) -> None:
    book = CarBook(tmp_path / "cars.json", virtual_units=False)
    book.keep(unit(10, "A", VIRTUAL_PASSPORT), VOLGA)
    assert book.details_of(unit(10, "A", VIRTUAL_PASSPORT)) is None
    assert not book.keeps(unit(10, "A", VIRTUAL_PASSPORT))
    assert book.keeps(unit(10, "A", "B"))
