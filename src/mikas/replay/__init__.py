"""A recording as a port: a virtual ECU that answers like the recorded one."""

from mikas.replay.build import load
from mikas.replay.car import ReplayCar
from mikas.replay.port import car_on, open_replay, playing, replay_bus

__all__ = ["ReplayCar", "car_on", "load", "open_replay", "playing", "replay_bus"]
