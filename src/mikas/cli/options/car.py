"""The car of a recording or a report: the options, and the details kept of the unit.

What an option gives is kept for the unit (`mikas.client.cars`), and stands in the recording; the
other details come from there, but for the mileage, which is another by the next time.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Final

from mikas import unkept
from mikas.cli.click_extensions import grouped, option_field, optional_field
from mikas.cli.options.parameter_types import whole
from mikas.i18n import Text

if TYPE_CHECKING:
    from mikas.client.cars import CarDetails
    from mikas.recording.capture.notes import Note
    from mikas.sampling.events import UnitFound

_UNKEPT = Text(
    "The car's details are in this recording, but can't be kept for the next one: {place}: {why}.",
    "Данные машины есть в этой записи, но для следующей не сохранились: {place}: {why}.",
)


@dataclass(frozen=True, slots=True)
class CarOptions:
    """The options; empty or None: not given."""

    car: str = option_field(
        "",
        "--car",
        metavar="TEXT",
        en="the car, as “Volga 3110”; kept for this unit",
        ru="машина, «Волга 3110»; запоминается",
    )
    plate: str = option_field(
        "",
        "--plate",
        metavar="TEXT",
        en="its number plate; kept for this unit",
        ru="госномер; запоминается",
    )
    mileage: int | None = optional_field(
        "--mileage",
        parse=whole(0, 9_999_999),
        metavar="KM",
        en="its mileage now, in km",
        ru="пробег сейчас, км",
    )
    workshop: str = option_field(
        "",
        "--workshop",
        metavar="TEXT",
        en="who measures; kept for all cars",
        ru="кто проводит измерение; запоминается",
    )

    @property
    def details(self) -> CarDetails:
        """The options as details, cleaned and bounded."""
        from mikas.client.cars import car_details

        return car_details(asdict(self))

    def note_maker(self) -> Callable[[UnitFound], Note | None]:
        """Return the `car` of a `Recorder`: options are of the first unit, not of another one."""
        from mikas.client.cars import NO_CAR, CarBook
        from mikas.client.connecting import STATE_VARIABLE, state_folder
        from mikas.recording.annotations.events import car_note

        virtual = bool(os.environ.get(STATE_VARIABLE))
        book = CarBook(state_folder() / "cars.json", virtual_units=virtual)
        given = self.details

        def note(unit: UnitFound) -> Note | None:
            kept = book.details_of(unit.identity)
            known = replace(kept, mileage=None) if kept else replace(NO_CAR, workshop=book.workshop)
            details = known if unit.another else given.over(known)
            if given and not unit.another:
                with unkept.saying_once(_UNKEPT, book.file.path):
                    book.keep(unit.identity, details)
            return car_note(unit.time, details) if details else None

        return note


car_options: Final = grouped(CarOptions)
"""The options that `log` and `report` share."""
