"""`python -m mikas`: the same as the `mikas` command."""

from mikas.cli.main import main

main()
