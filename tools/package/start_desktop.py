"""The program `mikas-dashboard` of the one folder: what an icon starts, without a console."""

from mikas.cli.main import desktop_main

desktop_main()
