"""``python -m beadband``."""

import sys

from beadband.cli import main

sys.exit(main())
