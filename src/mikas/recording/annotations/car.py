"""The car of a recording as a note: car, plate, mileage, workshop. The last one counts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict

from mikas.client.cars import CarDetails, car_details
from mikas.recording.capture.notes import Kind, Note


def car_note(time: float, details: CarDetails) -> Note:
    """Return the note of the car; it replaces the one before."""
    return Note(Kind.CAR, time, asdict(details))


def car_of(notes: Iterable[Note]) -> CarDetails:
    """Return the details in the last note of a car; empty ones without such a note."""
    found = CarDetails()
    for note in notes:
        if note.kind == Kind.CAR:
            found = car_details(note.data)
    return found
