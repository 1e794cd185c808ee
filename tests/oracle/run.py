"""Long runs of random chains: a line for every seed that fails, then what failures have in common.

python tests/oracle/run.py --seeds 2000 --start 0
python tests/oracle/run.py --seeds 2000 --similar
python tests/oracle/run.py --seeds 2000 --cut
python tests/oracle/run.py --seeds 2000 --wound
python tests/oracle/run.py --rotors --seeds 40

With `--loose`, of random linkages with play in a pin, beside simulations of some seconds each.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
import traceback
import warnings
from collections import defaultdict
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE)]

import compare  # noqa: E402
from scenes import Case, draw  # noqa: E402

Check = Callable[[Case], list[compare.Difference] | None]


def failures(case: Case | None, check: Check) -> list[str]:
    """Return what is wrong with the package's answer to a case, an exception included."""
    if case is None:
        return ["no case could be drawn"]
    try:
        differing = check(case) or []
    except Exception as error:  # A long run goes on whatever happens.
        innermost = traceback.extract_tb(error.__traceback__)[-1]
        text = " ".join(str(error).split())[:150]
        return [
            f"{type(error).__name__} ({Path(innermost.filename).stem}:{innermost.lineno}): {text}"
        ]
    differing.sort(key=lambda item: -item.size if item.size == item.size else 1.0)
    return [str(item) for item in differing]


def against_free_bodies(case: Case) -> list[compare.Difference]:
    """Return in what a sweep differs from the free bodies."""
    return compare.differences(case, compare.sweep_of(case))


def _ignoring_the_case(_: Case, seed: int) -> list[compare.Difference]:
    return compare.misjudged(seed)


def loose(seeds: range) -> int:
    """Run linkages with play; return 1 if an estimate without a doubt is too low."""
    from loose_linkages import draw, passed

    reversals = inside = unsafe = 0
    for seed in seeds:
        case = draw(seed)
        if case is None:
            continue
        try:
            found = passed(case)
        except Exception as error:  # A long run goes on whatever happens.
            print(f"{seed}: {type(error).__name__}: {' '.join(str(error).split())[:150]}")
            continue
        reversals += len(found)
        inside += sum(item.is_inside for item in found)
        unsafe += sum(item.is_unsafe for item in found)
        for item in found:
            if item.is_unsafe or not item.is_inside:
                print(
                    f"{seed} {case.kind} {case.joint}: {item.simulated:.5g} N, stated "
                    f"{item.item.least:.5g} to {item.item.greatest:.5g}; {item.item.verdict}"
                )
        sys.stdout.flush()
    print(f"{inside} of {reversals} reversals inside, {unsafe} too low without a doubt")
    return int(unsafe > 0)


def kind_of(message: str) -> str:
    """Return what kind of failure a message tells of, without joints and numbers."""
    error = re.match(r"(\w+) \(\w+:\d+\)", message)
    if error:
        return error.group(0)
    message = re.sub(r"\(\w+\) [Uo]+ not [Uo]+", "", message)
    message = re.sub(r"\b[jlbxf]\d+\b|[\d.e+-]+×|, [\d.e+-]+ away", "", message)
    return " ".join(message.replace(" of ", " ").split())


def rotors(seeds: range) -> int:
    """Run the critical speeds of random rigs; return 1 if any is wrong."""
    sys.path.insert(0, str(HERE.parent / "support"))
    import resonant_rigs

    count = 0
    for seed in seeds:
        try:
            rig = resonant_rigs.draw(seed)
            wrong, name = resonant_rigs.differences(rig), rig.name
        except Exception as error:  # As above.
            wrong, name = [f"{type(error).__name__}: {error}"], ""
        count += bool(wrong)
        print(f"seed {seed} {name}: {'; '.join(wrong) or 'right'}", flush=True)
    print(f"{count} of {len(seeds)} differ")
    return int(count > 0)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run seeds; return 1 if any failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=2000)
    parser.add_argument("--start", type=int, default=0)
    parser.add_argument("--turned", action="store_true", help="turn the frames of loops")
    parser.add_argument(
        "--similar", action="store_true", help="compare with chains of other sizes and masses"
    )
    parser.add_argument(
        "--cut", action="store_true", help="compare with chains whose loops are other joints"
    )
    parser.add_argument(
        "--wound", action="store_true", help="wind bushings of other chains over many turns"
    )
    parser.add_argument("--text", action="store_true", help="print the descriptions as well")
    parser.add_argument("--loose", action="store_true", help="linkages with play in a pin")
    parser.add_argument("--rotors", action="store_true", help="critical speeds instead of chains")
    options = parser.parse_args(arguments)
    if options.loose:
        return loose(range(options.start, options.start + options.seeds))
    if options.rotors:
        return rotors(range(options.start, options.start + options.seeds))
    warnings.simplefilter("error")
    print(f"testing {Path(compare.cd.__file__).parent}")
    failed: dict[str, list[int]] = defaultdict(list)
    features: dict[str, list[int]] = defaultdict(lambda: [0, 0])
    count, began = 0, time.perf_counter()
    for seed in range(options.start, options.start + options.seeds):
        try:
            case = draw(seed, options.turned)
        except Exception:  # As above.
            case = None
            traceback.print_exc()
        check: Check = against_free_bodies
        if options.similar:
            check = partial(compare.dissimilar, seed=seed)
        elif options.wound:
            check = partial(_ignoring_the_case, seed=seed)
        elif options.cut:
            check = partial(compare.cut_differently, seed=seed)
        wrong = failures(case, check)
        had = sorted(case.features) if case else []
        for feature in had:
            features[feature][0] += 1
            features[feature][1] += bool(wrong)
        if options.text and case:
            print(case.chain.text)
        if not wrong:
            continue
        count += 1
        failed[" + ".join(sorted({kind_of(message) for message in wrong}))].append(seed)
        more = f" (+{len(wrong) - 3} more)" if len(wrong) > 3 else ""
        print(f"{seed}: {'; '.join(wrong[:3])}{more} [{', '.join(had)}]")
        sys.stdout.flush()
    print(f"\n{count} of {options.seeds} seeds failed in {time.perf_counter() - began:.0f} s")
    for kind, seeds in sorted(failed.items(), key=lambda item: -len(item[1])):
        print(f"{len(seeds):5d}  {kind}: {seeds[:6]}")
    print("\nfeature: seeds, failed")
    for feature, (seen, bad) in sorted(features.items(), key=lambda item: -item[1][1]):
        print(f"  {feature}: {seen}, {bad}")
    return int(count > 0)


if __name__ == "__main__":
    raise SystemExit(main())
