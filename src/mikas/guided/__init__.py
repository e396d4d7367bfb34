"""Guided tests: what to do, what is measured meanwhile, and what follows from the numbers.

    *.toml ──► loading ──► GuidedTest ──► TestEngine ◄── rows with times, live or of a recording
                                              │ the present step, what is still missing
                                              ▼
               verdict (rules over measures) ──► TestResult ──► page, report, note of the recording

Tests are data (docs/guided-tests.md); formulas are the catalog's. Nothing here reads a clock or a
line. A test that lacks data ends with “can't tell”, never with a guess.
"""
