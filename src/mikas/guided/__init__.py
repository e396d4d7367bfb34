"""Guided tests: instructions for the driver, measures taken meanwhile, and a verdict from them.

    *.toml ──► loading ──► GuidedTest ──► TestEngine ◄── rows with times, live or of a recording
                                              │ the present step, the missing values
                                              ▼
               verdict (rules over measures) ──► TestResult ──► page, report, note of the recording

Tests are data (docs/reference/guided-tests.md); formulas are the catalog's. Nothing here reads a
clock or a line. A test that lacks data ends with the verdict `unknown`, never with a guess.
"""
