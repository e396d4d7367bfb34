"""Links: one interface to the wire. `open_link` turns a URL into a `Link`.

`find_ports` and `choose_port` find the URL. A scheme's libraries are imported when it is opened.
"""

from mikas.errors import PortKind
from mikas.link.base import CaptureTee, Chunk, Direction, Link, LinkWrapper, Sink
from mikas.link.clocks import WallClock
from mikas.link.ports import Port, choose_port, find_ports
from mikas.link.urls import open_link

__all__ = [
    "CaptureTee",
    "Chunk",
    "Direction",
    "Link",
    "LinkWrapper",
    "Port",
    "PortKind",
    "Sink",
    "WallClock",
    "choose_port",
    "find_ports",
    "open_link",
]
