"""The unit's memory: spaces to read (`spaces`) and to write (`writing`)."""

from mikas.client.memory.spaces import Memory as Memory
from mikas.client.memory.spaces import MemorySpace as MemorySpace
from mikas.client.memory.spaces import Run as Run
from mikas.client.memory.spaces import Written as Written
from mikas.client.memory.spaces import writing as writing
