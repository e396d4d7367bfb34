"""The program `mikas` of the one folder."""

from multiprocessing import freeze_support

freeze_support()  # a process of a pool is this program again

from mikas.cli.main import main  # noqa: E402  (a process of a pool does not come so far)

main()
