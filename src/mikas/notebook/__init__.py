"""A recording in a notebook: what `mikas.open(…)` shows of itself, and its chart.

recording ──► overview ──► wording ──► html · text      `recording` as the last line of a cell
    └──► panes, value_axes, time_axis, interruptions ──► drawing      `recording.plot()`
"""
