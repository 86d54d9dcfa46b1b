"""``python -m beadband.studies.correction``: the map of ``beadband/model/correction.json`` again."""

from __future__ import annotations

import argparse
import json
import sys

from beadband.errors import BeadbandError
from beadband.studies.correction import make
from beadband.studies.correction.report import tables


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m beadband.studies.correction", description=__doc__)
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of correction.json and of the releases")
    parser.add_argument("--scenes", type=int, default=2400, help="scenes of any law and band to fit to (%(default)s)")
    parser.add_argument("--catalogue", type=int, default=600, help="scenes like the catalogue's (%(default)s)")
    parser.add_argument("--held", type=int, default=400, help="held-out scenes of any kind, twice (%(default)s)")
    parser.add_argument("--held-catalogue", type=int, default=500, help="the same like the catalogue's (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="of all draws (%(default)s)")
    parser.add_argument("--jobs", type=int, default=None, help="processes (default: one per core)")
    given = vars(parser.parse_args(arguments))
    try:
        path = make(**given, say=lambda text: print(text, file=sys.stderr))
    except BeadbandError as error:
        print(error, file=sys.stderr)
        return 2
    print(tables(json.loads(path.read_text())))
    return 0


if __name__ == "__main__":
    sys.exit(main())
