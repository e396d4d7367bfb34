"""What gives a model to a host: usb-redir to QEMU, a file of usbfs to a program here."""
