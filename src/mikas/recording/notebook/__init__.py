"""A recording in a notebook: what `mikas.open(…)` shows of itself, and its chart.

Recording ──► overview ──► wording ──► html · text      `recording` as the last line of a cell
    └──► panes, value_axes, time_axis, interruptions ──► plot         `recording.plot()`
"""
