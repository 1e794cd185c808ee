"""Run: many seeds in worker processes, and what they found.

`python tests/fuzz/run.py descriptions --count 50000 --start 0 --workers 2`, the same with
`arguments`; `--report PATH` writes the findings as JSON; `show descriptions 17` prints a case.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from harness import FAMILIES, run, show


def main() -> int:
    """Run from the command line; 1 if anything was found."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for family in FAMILIES:
        options = commands.add_parser(family)
        options.add_argument("--count", type=int, default=10_000)
        options.add_argument("--start", type=int, default=0)
        options.add_argument("--workers", type=int, default=1)
        options.add_argument("--report", type=Path)
    options = commands.add_parser("show")
    options.add_argument("family", choices=FAMILIES)
    options.add_argument("seed", type=int)
    given = parser.parse_args()
    if given.command == "show":
        print(show(given.family, given.seed))
        return 0
    outcome = run(given.command, given.start, given.count, given.workers)
    print(outcome)
    if given.report is not None:
        content = [vars(item) for item in outcome.findings]
        given.report.write_text(json.dumps(content, indent=1), encoding="utf-8")
    return 1 if outcome.findings else 0


if __name__ == "__main__":
    sys.exit(main())
