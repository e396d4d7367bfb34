"""Damaged recordings whose truth is known, before every reader: `python -m fuzz exchanges`.

`sessions` records the real tester with a virtual unit whose data never repeat, `mutations` damages
the line and the file, `cases` makes case N of a seed. `readers` hold every reader equal to
`decode`, `inventions` each value shown equal to what the unit gave to that request (D13),
`wireshark` does both for tshark. `campaign` runs case after case and makes a finding small.
"""
