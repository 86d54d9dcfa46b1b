"""``python -m beadband``."""

from beadband.cli import program

if __name__ == "__main__":
    program()
