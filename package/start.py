"""The program `mikas` of the one folder."""

from multiprocessing import freeze_support

from mikas.cli.main import main

freeze_support()  # a process of a pool is this program again
main()
