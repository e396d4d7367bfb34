"""python -m bench.russian: writes the Russian page of the benchmarks from the English one."""

from bench.russian import write

write()
