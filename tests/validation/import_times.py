"""What a command spends on importing: the modules that take longest, from python -X importtime.

    python tests/validation/import_times.py [--repeats 5] [--top 12]

For each command the quickest of the repeats counts. Kept in docs/verified.md.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile

COMMANDS = (["--help"], ["plan"], ["ask", "--tolerance", "0.02"], ["run", "--beads", "120", "--for", "speed"])


def times_us(words: list[str]) -> dict[str, int]:
    """Microseconds of each module alone, and their sum under ``total``."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, "-X", "importtime", "-m", "beadband", *words], cwd=folder,
                              capture_output=True, text=True, check=True)  # fmt: skip
    found: dict[str, int] = {}
    for line in done.stderr.splitlines():
        if line.startswith("import time:") and "[us]" not in line:
            alone, _, name = line.removeprefix("import time:").split("|")
            found[name.strip()] = found.get(name.strip(), 0) + int(alone)
    return {"total": sum(found.values()), **found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--top", type=int, default=8)
    options = parser.parse_args()
    for words in COMMANDS:
        runs = [times_us(words) for _ in range(options.repeats)]
        best = min(runs, key=lambda one: one["total"])
        ranked = sorted(((us, name) for name, us in best.items() if name != "total"), reverse=True)[: options.top]
        listed = ", ".join(f"{name} {us / 1e3:.1f}" for us, name in ranked)
        print(f"beadband {' '.join(words)}: {best['total'] / 1e3:.0f} ms in {len(best) - 1} modules; {listed}")


if __name__ == "__main__":
    main()
