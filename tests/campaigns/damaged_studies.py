"""Stores of studies that are damaged at random: is any number another one without a word?

    python tests/campaigns/damaged_studies.py --rounds 500

A study is kept in a store, with results that are no numbers, cases that failed and coordinates.
Then bits are flipped in its files, or they are cut off, emptied, filled with zeros or noise,
lengthened or deleted, one to three at a time. Whoever looks then is told, or sees what was
computed; a run is refused, or leaves the store as it would be, at its length or longer.
"""

from __future__ import annotations

import argparse
import random
import shutil
import tempfile
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import xarray

import cardan_dyn as cd
from cardan_dyn import studies

LONG, SHORT = 11, 9
"""Points along the first dimension, and those of them that the store has before it is damaged."""


def computed(a: float, b: float) -> xarray.Dataset:
    if b > 2.5 and a > 5.5:
        raise ValueError(f"{b} is too great")
    at = np.linspace(0.0, 1.0, 4)
    curve = ("at", a + b * at, {"units": "N"})
    return xarray.Dataset(
        {"sum": ((), a + b, {"units": "m"}), "curve": curve, "nothing": ((), np.nan)},
        {"at": ("at", at, {"units": "s"})},
        {"title": "sums"},
    )


def study_of(store: Path, count: int = SHORT) -> studies.Study:
    axes = {"a": (np.arange(float(count)), "m"), "b": (studies.Line(0.0, 3.0, 7), "m")}
    return cd.study(computed, axes, store=store, workers=1, chunk={"a": 4, "b": 3})


def damaged(chance: random.Random, store: Path) -> list[str]:
    """Damage one to three files, and return what was done."""
    done = []
    for _ in range(chance.randint(1, 3)):
        path = chance.choice(sorted(item for item in store.rglob("*") if item.is_file()))
        data, kind = bytearray(path.read_bytes()), chance.choice(KINDS)
        if kind == "deleted":
            path.unlink()
        elif data:
            if kind == "flipped":
                data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
            elif kind == "cut":
                del data[chance.randrange(len(data)) :]
            elif kind == "lengthened":
                data += chance.randbytes(chance.randint(1, 9))
            elif kind == "noise":
                data = bytearray(chance.randbytes(len(data)))
            else:
                data = bytearray(len(data) if kind == "zeros" else 0)
            path.write_bytes(data)
        done.append(f"{path.relative_to(store)} {kind}")
    return done


KINDS = ("flipped", "flipped", "flipped", "cut", "empty", "zeros", "noise", "lengthened", "deleted")


def looked_at(study: studies.Study) -> tuple[xarray.Dataset, list[Any]]:
    failures = study.failures
    return study.dataset.load(), failures.values.tolist()


def refuse_other(found: Any, expected: Any, *, whole: bool) -> None:
    """Raise an error where a case that counts is not what was computed."""
    data, failures = found
    reference, failed = expected
    assert list(data.variables) == list(reference.variables)
    assert reference.attrs["title"] == data.attrs["title"]
    there = data.state.values > 0
    assert not whole or there.all()
    for name, item in reference.variables.items():
        values = data.variables[name]
        assert (values.dims, values.attrs, values.dtype) == (item.dims, item.attrs, item.dtype)
        counts = there if item.dims[:2] == ("a", "b") else slice(None)
        np.testing.assert_array_equal(values.values[counts], item.values[counts], err_msg=name)
    assert [row for row in failed if there[row[0], row[1]]] == failures


def campaign(rounds: int, seed: int) -> Counter[str]:
    tally: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        expected = {
            count: looked_at(study_of(folder / f"{count}.zarr", count).run())
            for count in (SHORT, LONG)
        }
        for index in range(rounds):
            chance = random.Random(f"{seed} {index}")
            store = folder / "damaged.zarr"
            shutil.copytree(folder / f"{SHORT}.zarr", store)
            done, count = damaged(chance, store), chance.choice((SHORT, SHORT, LONG))
            try:
                tally[_round(store, count, expected)] += 1
            except Exception as error:
                raise AssertionError(f"round {index} of seed {seed}: {done}") from error
            shutil.rmtree(store)
    return tally


def _round(store: Path, count: int, expected: Any) -> str:
    """Look at a damaged store, go on with it, and return how that ended."""
    try:
        refuse_other(looked_at(study_of(store)), expected[SHORT], whole=False)
        seen = "seen"
    except cd.CardanError:
        seen = "refused to be seen"
    study = study_of(store, count)
    try:
        plan = study.plan()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            study.run()
    except cd.CardanError:
        return f"{seen}, refused to go on"
    refuse_other(looked_at(study), expected[count], whole=True)
    # A look at the files again, and not at what the study remembers.
    refuse_other(looked_at(study_of(store, count)), expected[count], whole=True)
    if said:
        again = "makes it again" if plan.damaged else "writes it anew"
        assert f"this run {again}" in str(said[0].message)
        return f"{seen}, mended and said"
    # What only a plan tells of: states and results that are gone together, or nothing that matters.
    return f"{seen}, computed again" if plan.done < SHORT * 7 else f"{seen}, as it was"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--rounds", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for ending, number in sorted(campaign(given.rounds, given.seed).items()):
        print(f"{number:6} {ending}")
    print("no number was another one without a word")
