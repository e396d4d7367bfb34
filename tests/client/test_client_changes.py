"""What changes a unit: faults erased, parameters and lists written, jumps, raw requests."""

from __future__ import annotations

import pytest
from client_harness import bench, ecu_on, lines

from mikas.client.parameters.parameters import KEEPING_UNKNOWN
from mikas.commands import Safety
from mikas.errors import (
    AddressOutOfRange,
    DamagedResponse,
    EcuRefused,
    ListLost,
    NoConnection,
    NoList,
    NoResponse,
    NotConfirmed,
    NotSupported,
    ReadBackDiffers,
    UnknownParameter,
    UsageError,
    ValueDoesNotFit,
    WriteRefused,
)
from mikas.virtual.fault_injector import LineFault
from virtual_harness import DATA, FAULTS, TableCar


class TestFaults:
    def test_faults_come_in_the_units_order_with_texts(self):
        faults = ecu_on(bench()).faults()
        assert [f.code for f in faults] == FAULTS
        assert faults[0].known
        assert all(f.text.ru and f.text.en for f in faults if f.known)

    def test_an_unknown_number_stays_a_number(self):
        (fault,) = ecu_on(bench(faults=[0xE0])).faults()
        assert (fault.code, fault.known) == (0xE0, False)

    def test_no_stored_fault_is_an_empty_result(self):
        assert ecu_on(bench(faults=[])).faults() == ()

    def test_one_stored_fault_is_not_a_refusal(self):
        assert [f.code for f in ecu_on(bench(faults=[1], unknown="01")).faults()] == [1]

    @pytest.mark.parametrize("unknown", ["silent", "01"])
    def test_a_unit_without_02_can_neither_read_nor_erase_faults(self, unknown):
        ecu = ecu_on(bench(missing="02", unknown=unknown))
        with pytest.raises(NotSupported):
            ecu.faults()
        with pytest.raises(NotSupported):
            ecu.erase_faults()

    def test_an_erase_returns_the_faults_before_and_after(self, tmp_path):
        it = bench()
        changes = []
        ecu = ecu_on(it, confirm=lambda c: changes.append(c) or True, journal=tmp_path / "j")
        erased = ecu.erase_faults()
        assert [f.code for f in erased.before] == FAULTS
        assert erased.after == ()
        assert it.requests(0x62) == [b"\x62\x0e\x08", b"\x62\x0e\x00"]
        assert changes[0].before == bytes(FAULTS).hex(" ").upper()
        assert lines(tmp_path / "j")[1]["outcome"] == ""

    @pytest.mark.parametrize(
        ("speed", "warning"),
        [
            (DATA[0x29], "The engine is running (840 rpm)"),
            (b"\x00", ""),
            (None, ""),  # the unit does not say
        ],
    )
    def test_an_erase_with_the_engine_running_is_asked_about_as_such(self, speed, warning):
        it = bench()
        if speed is None:
            del it.car.data[0x29]
        else:
            it.car.data[0x29] = speed
        changes = []
        ecu = ecu_on(it, confirm=lambda c: bool(changes.append(c)))
        with pytest.raises(NotConfirmed):
            ecu.erase_faults()
        assert not it.requests(0x62)
        text = changes[0].warning
        assert (text.en if text else "").startswith(warning)
        assert bool(text) == bool(warning)

    def test_what_comes_back_at_once_is_shown(self):
        it = bench(faults=[13, 53])
        ecu = ecu_on(it)
        answer = it.bus.ecu.responder.answer

        class Responder:
            def __getattr__(self, name):
                return getattr(responder, name)

            def answer(self, body, now):
                answered = answer(body, now)
                if body == b"\x62\x0e\x00":
                    it.car.faults.append(53)
                return answered

        responder, it.bus.ecu.responder = it.bus.ecu.responder, Responder()
        erased = ecu.erase_faults()
        assert [f.code for f in erased.before] == [13, 53]
        assert [f.code for f in erased.after] == [53]

    @pytest.mark.parametrize("lost", [(LineFault.LOST,), (None, LineFault.LOST)])
    def test_a_lost_answer_does_not_leave_it_half_done(self, lost):
        it = bench()
        ecu = ecu_on(it)
        it.next_faults(None, *lost)  # the faults before, then the answers to the two writes
        assert ecu.erase_faults().after == ()

    def test_a_refused_erase_is_an_error(self):
        with pytest.raises(WriteRefused):
            ecu_on(bench(missing="write", unknown="01")).erase_faults()
        with pytest.raises(NotSupported):
            ecu_on(bench(missing="write")).erase_faults()


class TestWritingAParameter:
    def test_a_value_is_encoded_written_and_read_back(self):
        it = bench()
        changes = []
        ecu = ecu_on(it, confirm=lambda c: changes.append(c) or True)
        written = ecu.write_parameter("UGB", 12.34)
        assert written.before.raw == DATA[0x59]
        assert written.after.value == pytest.approx(12.34)
        assert written.name == "UGB"
        assert it.requests(0x62) == [b"\x62\x59" + (1234).to_bytes(2, "little")]
        (change,) = changes
        assert change.before == DATA[0x59].hex(" ").upper()
        assert change.after == "D2 04"
        assert change.safety is Safety.LASTING
        assert change.warning == KEEPING_UNKNOWN

    def test_raw_bytes_are_written_and_read_back(self):
        it = bench()
        written = ecu_on(it).write_parameter("ssm", raw=b"\x1e")
        assert written.after.raw == b"\x1e"
        ecu = ecu_on(it)
        assert ecu.write_parameter("0x5B", 31).after.value == 31

    def test_a_value_is_encoded_by_the_sessions_interpretation(self):
        it = bench()
        ecu_on(it, interpretation="alternative").write_parameter("RCOK", 0.0)
        assert it.requests(0x62) == [b"\x62\x42\x80"]

    @pytest.mark.parametrize(
        ("arguments", "error"),
        [
            (("SSM", 256), ValueDoesNotFit),
            (("SSM", -1), ValueDoesNotFit),
            (("SSM", float("nan")), ValueDoesNotFit),
            (("SSM", float("inf")), ValueDoesNotFit),
            (("SSM", "30"), ValueDoesNotFit),
            (("TWAT", 300), ValueDoesNotFit),
            (("RXX", True), ValueDoesNotFit),
            (("RXX", 1), ValueDoesNotFit),
            (("SSM",), UsageError),
            (("SSMM", 1), UnknownParameter),
        ],
    )
    def test_what_does_not_fit_is_refused_before_anything_is_sent(self, arguments, error):
        it = bench()
        ecu = ecu_on(it)
        with pytest.raises(error):
            ecu.write_parameter(*arguments)
        assert it.requests() == []

    @pytest.mark.parametrize("raw", [b"", b"\x01\x02"])
    def test_raw_bytes_of_another_size_are_refused(self, raw):
        it = bench()
        with pytest.raises(ValueDoesNotFit):
            ecu_on(it).write_parameter("SSM", raw=raw)
        assert it.requests() == []

    def test_value_and_raw_bytes_together_are_refused(self):
        with pytest.raises(UsageError):
            ecu_on(bench()).write_parameter("SSM", 1, raw=b"\x01")

    def test_a_flag_goes_as_a_whole_byte(self):
        assert ecu_on(bench()).write_parameter("RXX", raw=b"\x04").after.value is True

    def test_a_unit_that_keeps_another_value(self, tmp_path):
        class Stubborn(TableCar):
            def write(self, code, data):
                return True

        it = bench(car=Stubborn(DATA))
        ecu = ecu_on(it, journal=tmp_path / "journal")
        with pytest.raises(ReadBackDiffers, match="SSM") as caught:
            ecu.write_parameter("SSM", 1)
        assert DATA[0x5B].hex().upper() in str(caught.value)
        assert lines(tmp_path / "journal")[1]["state"] == "failed"

    def test_a_parameter_that_can_not_be_read_is_written_without_before_and_after(self):
        it = bench({0x29: b"\x10"})
        ecu = ecu_on(it)
        written = ecu.write_parameter("0x0E", 8)
        assert (written.before, written.after) == (None, None)
        assert it.requests(0x62) == [b"\x62\x0e\x08"]

    @pytest.mark.parametrize("known", [False, True])
    def test_a_lost_answer_is_settled_by_reading_back(self, known):
        it = bench()
        ecu = ecu_on(it)
        if known:
            ecu.write_parameter("SSM", 29)
        it.next_faults(None, LineFault.LOST)  # the value before, then the answer to the write
        assert ecu.write_parameter("SSM", 30).after.value == 30
        assert len(it.requests(0x62)) == 1 + known  # never sent twice

    def test_a_lost_answer_that_nothing_settles_is_an_error(self):
        it = bench(DATA | {0x5B: b"\x1e"})
        ecu = ecu_on(it)
        it.next_faults(None, LineFault.LOST)
        with pytest.raises((NoResponse, NotSupported)):
            ecu.write_parameter("SSM", 30)  # it was 30 before: no telling
        assert len(it.requests(0x62)) == 1

    def test_a_damaged_answer_is_never_a_reason_to_write_twice(self):
        it = bench()
        ecu = ecu_on(it)
        it.next_faults(None, LineFault.DAMAGED)
        with pytest.raises(DamagedResponse):
            ecu.write_parameter("SSM", 30)
        assert len(it.requests(0x62)) == 1

    @pytest.mark.parametrize("unknown", ["silent", "01"])
    def test_a_unit_that_can_not_write_refuses_and_keeps_its_value(self, unknown):
        ecu = ecu_on(bench(missing="write", unknown=unknown))
        with pytest.raises(EcuRefused):
            ecu.write_parameter("SSM", 30)
        assert ecu.read("SSM")["SSM"].raw == DATA[0x5B]


class TestTheList:
    def test_a_list_that_was_set_is_read_in_its_order(self):
        it = bench()
        ecu = ecu_on(it)
        assert ecu.set_list("twat", "RXX", "BITPOW", "INJ") == ("TWAT", "RXX", "BITPOW", "INJ")
        for _ in range(2):
            readings = ecu.read_list()
            assert list(readings) == ["TWAT", "RXX", "BITPOW", "INJ"]
            assert all(r.raw == DATA[r.parameter.code] for r in readings.values())
        assert it.requests() == [b"\x64\x1a\x07\x3f", b"\x63", b"\x63"]

    def test_a_list_to_set_is_described_in_plain_words(self, tmp_path):
        asked = []
        ecu = ecu_on(bench(), confirm=lambda c: asked.append(c) or True, journal=tmp_path / "j")
        ecu.set_list("TWAT", "INJ")
        assert asked[0].what.en == "set the unit's list to 2 parameters"
        assert asked[0].what.ru.endswith("2 параметра")
        assert lines(tmp_path / "j")[0]["change"] == asked[0].what.en

    def test_without_names_the_list_is_all_of_the_catalog(self):
        ecu = ecu_on(bench())
        assert len(ecu.set_list()) == 23
        assert {r.parameter.code: r.raw for r in ecu.read_list().values()} == DATA

    def test_without_a_list_there_is_nothing_to_read(self):
        it = bench()
        ecu = ecu_on(it)
        with pytest.raises(UsageError, match="set_list"):
            ecu.read_list()
        assert it.requests() == []

    @pytest.mark.parametrize("names", [("TWAT",), ("TWAT", "INJ")])
    def test_a_forgotten_list_gives_no_wrong_value(self, names):
        it = bench()
        ecu = ecu_on(it)
        ecu.set_list(*names)
        ecu.read_list()
        it.power_cycle(ecu)
        with pytest.raises(ListLost, match="may forget its list when its supply goes off"):
            ecu.read_list()
        with pytest.raises(NoList, match="set_list"):
            ecu.read_list()
        ecu.set_list(*names)
        assert ecu.read_list()["TWAT"].raw == DATA[0x1A]

    def test_a_list_set_raw_is_not_read_as_the_old_one(self):
        ecu = ecu_on(bench())
        ecu.set_list("TWAT", "THR")
        ecu.raw(b"\x64\x29\x2c")
        with pytest.raises(UsageError):
            ecu.read_list()

    def test_a_list_that_is_too_long_is_refused_and_can_not_be_read(self):
        ecu = ecu_on(bench(max_list=3))
        with pytest.raises(WriteRefused, match="too long"):
            ecu.set_list()
        with pytest.raises(UsageError):
            ecu.read_list()


class TestGoto:
    def test_silence_is_what_is_expected(self, tmp_path):
        it = bench()
        ecu = ecu_on(it, confirm=lambda _: True, journal=tmp_path / "j")
        assert ecu.goto(0x1234) == b""
        assert it.requests(0x41) == [b"\x41\x34\x12"]
        assert lines(tmp_path / "j")[0]["change"] == "jump to 1234"
        assert ecu.read("TWAT")

    @pytest.mark.parametrize("address", [-1, 0x10000])
    def test_an_address_out_of_range_is_refused_before_anything_is_sent(self, address):
        it = bench()
        with pytest.raises(AddressOutOfRange):
            ecu_on(it, confirm=lambda _: True).goto(address)
        assert it.requests() == []


class TestRaw:
    def test_reads_pass_unasked(self, tmp_path):
        def never(change):
            raise AssertionError

        ecu = ecu_on(bench(), confirm=never, journal=tmp_path / "j")
        assert ecu.raw(b"\x01") == b"\x0a"
        assert ecu.raw(b"\x61\x1a") == DATA[0x1A]
        assert not (tmp_path / "j").exists()

    def test_no_response_is_none(self):
        assert ecu_on(bench()).raw(b"\x61\xee") is None
        assert ecu_on(bench()).raw(b"\x99") is None

    def test_an_empty_body_is_refused_before_anything_is_sent(self):
        it = bench()
        with pytest.raises(UsageError):
            ecu_on(it).raw(b"")
        assert it.requests() == []

    def test_a_stream_is_ended_before_the_next_request(self):
        ecu = ecu_on(bench())
        assert ecu.raw(b"\x71\x1a\x29")
        assert ecu.read("TWAT")["TWAT"].raw == DATA[0x1A]

    def test_damage_is_an_error(self):
        it = bench()
        ecu = ecu_on(it)
        it.next_faults(LineFault.DAMAGED)
        with pytest.raises(DamagedResponse):
            ecu.raw(b"\x61\x1a")
        assert ecu.read("TWAT")

    def test_an_unknown_command_needs_a_confirmation(self):
        changes = []
        ecu = ecu_on(bench(unknown="01"), confirm=lambda c: changes.append(c) or True)
        assert ecu.raw(b"\x99\x01") == b"\x01"
        assert changes[0].command == "?"
        assert changes[0].safety is Safety.LASTING
        assert "99 01" in changes[0].what.en

    def test_without_a_unit_raw_is_no_connection(self):
        it = bench()
        ecu = ecu_on(it)
        ecu.read("TWAT")
        it.car.on = False
        ecu.raw(b"\x61\x1a")
        with pytest.raises(NoConnection):
            ecu.read("TWAT")
