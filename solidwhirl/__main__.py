"""`python -m solidwhirl` is the command `solidwhirl`."""

from solidwhirl.cli import main

main()
