"""Runs a campaign: a line for every seed that fails, then what failures have in common.

python tests/oracle/run.py CAMPAIGN [--seeds N] [--start K]
"""

from __future__ import annotations

import argparse
import re
import sys
import time
import traceback
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

import compare  # noqa: E402
import contacts  # noqa: E402
import free_rotations  # noqa: E402
import half_power  # noqa: E402
import long_swings  # noqa: E402
import loose_linkages  # noqa: E402
import near_singular  # noqa: E402
import random_derivatives  # noqa: E402
import random_reports  # noqa: E402
import resonant_rigs  # noqa: E402
import separatrices  # noqa: E402
import verdicts  # noqa: E402
from scenes import Case, draw  # noqa: E402

Answer = tuple[list[str], list[str]]
"""What is wrong with the package's answer to a seed, and what is counted: what the case is made of
and what became of it, some of it perhaps several times."""


class Campaign(NamedTuple):
    """What is asked, of each seed."""

    asks: str
    ask: Callable[[int], Answer]


def _of_chains(
    check: Callable[[Case, int], list[compare.Difference] | None], turns: bool = False
) -> Callable[[int], Answer]:
    """Return what asks a check of the chain that a seed draws."""

    def ask(seed: int) -> Answer:
        case = draw(seed, turns)
        differing = check(case, seed) or []
        differing.sort(key=lambda item: -item.size if item.size == item.size else 1.0)
        return [str(item) for item in differing], sorted(case.features)

    return ask


def _against_free_bodies(case: Case, _: int) -> list[compare.Difference]:
    return compare.differences(case, compare.sweep_of(case))


def _wound(seed: int) -> Answer:
    return [str(item) for item in compare.misjudged(seed)], []


CAMPAIGNS = {
    "chains": Campaign("random chains against free bodies", _of_chains(_against_free_bodies)),
    "turned": Campaign(
        "the same with frames of loops turned along their freedoms",
        _of_chains(_against_free_bodies, turns=True),
    ),
    "similar": Campaign("chains beside those of other sizes", _of_chains(compare.dissimilar)),
    "cut": Campaign("chains beside those cut elsewhere", _of_chains(compare.cut_differently)),
    "held": Campaign(
        "scenes told to hold joints elsewhere beside those made so",
        _of_chains(compare.held_elsewhere),
    ),
    "derivatives": Campaign(
        "derivatives of chains beside differences in fifty digits", random_derivatives.ask
    ),
    "wound": Campaign("bushings wound over many turns", _wound),
    "loose": Campaign("simulations of linkages with play in a pin", loose_linkages.ask),
    "peaks": Campaign(
        "what scans of linkages print, beside all they know", loose_linkages.ask_peaks
    ),
    "rotors": Campaign("critical speeds, also of wider ranges", resonant_rigs.ask),
    "half_power": Campaign("half power of resonances, by shooting", half_power.ask),
    "near_singular": Campaign("starts near singular configurations", near_singular.ask),
    "verdicts": Campaign("verdicts on random drive lines", verdicts.ask),
    "reports": Campaign("extremes of few samples by closed forms", random_reports.ask),
    "separatrices": Campaign("motions beside unstable positions", separatrices.ask),
    "long_swings": Campaign("long motions, and events of many zeros", long_swings.ask),
    "free_rotations": Campaign("bodies that turn freely, by quaternions", free_rotations.ask),
    "contacts": Campaign("energy of pins that strike and slide", contacts.ask),
}


def answer(campaign: Campaign, seed: int) -> Answer:
    """Return the answer to a seed; an exception is wrong."""
    try:
        return campaign.ask(seed)
    except Exception as error:  # A long run goes on whatever happens.
        innermost = traceback.extract_tb(error.__traceback__)[-1]
        place = f"{Path(innermost.filename).stem}:{innermost.lineno}"
        return [f"{type(error).__name__} ({place}): {' '.join(str(error).split())[:150]}"], []


def kind_of(message: str) -> str:
    """Return what kind of failure a message tells of, without joints and numbers."""
    error = re.match(r"(\w+) \(\w+:\d+\)", message)
    if error:
        return error.group(0)
    message = re.sub(r"\(\w+\) [Uo]+ not [Uo]+", "", message)
    message = re.sub(r"\b[jlbxf]\d+\b|[\d.e+-]+×|, [\d.e+-]+ away", "", message)
    message = re.sub(r"[+-]?\d[\d.]*(e[+-]?\d+)?", "", message)
    return " ".join(message.replace(" of ", " ").split())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run seeds; return 1 if any failed."""
    width = max(map(len, CAMPAIGNS))
    listed = "\n".join(f"  {name:{width}}  {item.asks}" for name, item in CAMPAIGNS.items())
    parser = argparse.ArgumentParser(
        description=f"{__doc__}\n{listed}", formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("campaign", choices=CAMPAIGNS, metavar="CAMPAIGN")
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--start", type=int, default=0)
    options = parser.parse_args(arguments)
    campaign = CAMPAIGNS[options.campaign]
    warnings.simplefilter("error")
    print(f"testing {Path(compare.cd.__file__).parent}: {campaign.asks}")
    failed: dict[str, list[int]] = defaultdict(list)
    seen: Counter[str] = Counter()
    bad: Counter[str] = Counter()
    began = time.perf_counter()
    for seed in range(options.start, options.start + options.seeds):
        wrong, counted = answer(campaign, seed)
        seen.update(counted)
        if not wrong:
            continue
        bad.update(set(counted))
        failed[" + ".join(sorted({kind_of(message) for message in wrong}))].append(seed)
        more = f" (+{len(wrong) - 3} more)" if len(wrong) > 3 else ""
        print(f"{seed}: {'; '.join(wrong[:3])}{more} [{', '.join(counted)}]", flush=True)
    count = sum(map(len, failed.values()))
    print(f"\n{count} of {options.seeds} seeds failed in {time.perf_counter() - began:.0f} s")
    for kind, seeds in sorted(failed.items(), key=lambda item: -len(item[1])):
        print(f"{len(seeds):5d}  {kind}: {seeds[:6]}")
    print("\nwhat: how often, in how many seeds that failed")
    for what, number in sorted(seen.items(), key=lambda item: (-bad[item[0]], -item[1])):
        print(f"  {what}: {number}, {bad[what]}")
    return int(count > 0)


if __name__ == "__main__":
    raise SystemExit(main())
