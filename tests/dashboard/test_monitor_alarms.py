"""Alarms of the wanted channels; those of the others are kept."""

from __future__ import annotations

from mikas.catalog import shipped

LOW, FINE = 90, 138  # tenths of a volt; an alarm below 10 V


def alarms(message):
    return [(alarm["name"], alarm["level"]) for alarm in message["state"]["alarms"]]


def voltage(rig, raw):
    """Set the supply voltage that the unit sends from now on."""
    car = rig.cars.car(rig.dashboard.connection.port.url)
    car.write(shipped().parameter("UACC").code, bytes([raw]))


def plan(rig, *names):
    """Asks for these alone, and waits until they come."""
    wanted = [{"name": name} for name in names]
    rig.put("/plan", {"wanted": wanted, "method": "batch", "rate": 5})
    return rig.until(lambda it: it.get("data", {}).get("names") == list(names))


def test_an_alarm_is_there_again_when_its_channel_is_requested_again(idle):
    voltage(idle, LOW)
    idle.until(lambda it: alarms(it) == [("UACC", "warning")])
    assert alarms(plan(idle, "TWAT")) == []  # not sampled: its level is unknown
    plan(idle, "TWAT", "UACC")
    idle.until(lambda it: alarms(it) == [("UACC", "warning")])
    assert idle.get("/state")["alarm_count"] == 1


def test_one_that_ended_meanwhile_is_over(idle):
    voltage(idle, LOW)
    idle.until(lambda it: alarms(it) == [("UACC", "warning")])
    plan(idle, "TWAT")
    voltage(idle, FINE)
    plan(idle, "TWAT", "UACC")
    idle.until(lambda it: it["state"]["samples"] and alarms(it) == [])


def test_an_unplugged_adapter_leaves_no_alarm_of_the_last_value(idle):
    voltage(idle, LOW)
    idle.until(lambda it: alarms(it) == [("UACC", "warning")])
    idle.cars.pull()
    idle.until(lambda it: it["state"]["line"] == "no-port" and alarms(it) == [])
    idle.cars.put_back()
    idle.until(lambda it: alarms(it) == [("UACC", "warning")])
