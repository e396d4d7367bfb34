"""Which car a recording is of, and the folder of its partition."""

from __future__ import annotations

from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mikas.client.cars import CarDetails
from mikas.fleet.cars import UNKNOWN, KnownBy, car_key, partition, plate_key
from mikas.recording.annotations.events import RecordedUnit
from mikas.virtual import VIRTUAL_PASSPORT

UNIT = RecordedUnit(version_code=0x0A, passport=("МИКАС 7.1", None, "241.3763", "2000.09.27"))


@pytest.mark.parametrize(
    "typed", ["А123ВС52", "а 123 вс 52", "A123BC52", "a123bc 52", "А·123·ВС-52", "a１23BC52"]
)
def test_a_plate_is_one_however_it_is_typed(typed) -> None:
    assert plate_key(typed) == "A123BC52"


def test_a_car_is_identified_by_given_name_plate_own_name_or_unit_in_this_order() -> None:
    details = CarDetails("Волга  синяя", "е777кх99")
    assert car_key("Моя", details, UNIT) == ("МОЯ", KnownBy.GIVEN)
    assert car_key("", details, UNIT) == ("E777KX99", KnownBy.PLATE)
    assert car_key("", CarDetails("Волга  Синяя"), UNIT) == ("волга синяя", KnownBy.NAME)
    name, known_by = car_key("", CarDetails(), UNIT)
    assert known_by is KnownBy.UNIT
    assert name is not None
    assert name.startswith("unit ")
    assert car_key("", CarDetails(), None) == (None, None)


def test_a_unit_is_known_by_all_pieces_of_its_passport() -> None:
    other = RecordedUnit(version_code=0x0A, passport=("МИКАС 7.1", None, "241.3764", "2000.09.27"))
    model = RecordedUnit(version_code=0x09, passport=UNIT.passport)
    names = {car_key("", CarDetails(), unit).name for unit in (UNIT, other, model)}
    assert len(names) == 3


@pytest.mark.parametrize(
    "passport", [None, (), (None,) * 8, ("", " ", None), (VIRTUAL_PASSPORT, "1")]
)
def test_a_unit_without_a_passport_of_its_own_is_unknown(passport) -> None:
    unit = RecordedUnit(version_code=0x0A, passport=passport)
    assert car_key("", CarDetails(), unit) == (None, None)


@given(st.text(alphabet="🚗Ў/ a\U00020000", min_size=1))
def test_a_long_name_is_cut_to_what_a_folder_may_have(text) -> None:
    for details in (CarDetails(text), CarDetails("", text)):
        name, _ = car_key("", details, None)
        assert len(partition(name, None).partition("/")[0].encode()) <= 255


@given(st.text())
def test_a_partition_is_two_folders_whatever_the_name(name) -> None:
    car, day = partition(name, None).split("/")
    assert day == f"day={UNKNOWN}"
    assert car.startswith("car=")
    folder = car.removeprefix("car=")
    assert folder == UNKNOWN or unquote(folder, errors="surrogatepass") == name
    assert not set(folder) & set('/\\=:*?"<>|[]{}. \n\x00')


@given(st.text(max_size=300))
def test_a_plate_is_bounded(text) -> None:
    assert len(plate_key(text)) <= 60
