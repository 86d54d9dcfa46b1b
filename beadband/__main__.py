"""``python -m beadband``."""

from beadband.cli import program

program()
