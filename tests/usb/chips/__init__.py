"""USB serial chips as models, at the level of requests and packets.

    host's driver ── transport ── Device ── Uart ── Line: a car's unit, or a test

Each is made from what the drivers of Linux ask and expect, not from silicon. Two witnesses
keep a model honest: those drivers themselves, to which it is given by usb-redir in QEMU
(`redir_rig`), and Chromium's WebUSB, to which it is given as a file of usbfs (`usbfs_rig`),
both in `usb.transports`.

No module here opens, waits or reads a clock; `now` is the caller's.
"""
