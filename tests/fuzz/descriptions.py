"""Descriptions: a seed to a description, which may be broken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from random import Random
from xml.etree import ElementTree

from bases import base
from damage import break_elements, break_text, break_yaml


@dataclass(frozen=True)
class Case:
    """A description, and how to load it.

    Attributes:
        text: the main text.
        name: of the main file; None if the text itself is handed over.
        beside: other files by name.
        encoding: of the main file.
        strict: whether impossible inertias are to be refused.
        drives, held: a scene that the description allowed before it was broken.
        steps: what was done to it.
    """

    text: str
    name: str | None
    beside: Mapping[str, str]
    encoding: str
    strict: bool
    drives: tuple[str, ...]
    held: Mapping[str, float]
    steps: tuple[str, ...]

    def source(self, directory: Path) -> str | Path:
        """Return what to hand to `load`; files are written into a directory."""
        if self.name is None:
            return self.text
        for name, text in self.beside.items():
            (directory / name).write_text(text, encoding="utf-8", errors="surrogatepass")
        path = directory / self.name
        path.write_text(self.text, encoding=self.encoding, errors="surrogatepass")
        return path

    def __str__(self) -> str:
        how = f"steps: {', '.join(self.steps) or 'none'}; strict: {self.strict}"
        parts = [f"{how}; file: {self.name}", self.text]
        parts += [f"--- {name}\n{text}" for name, text in self.beside.items()]
        return "\n".join(parts)


def case(seed: int) -> Case:
    """Return the description that belongs to a seed."""
    rng = Random(f"description {seed}")
    start = base(rng)
    text, beside, steps = start.text, dict(start.beside), []
    count = rng.choices([0, 1, 2, 3, 5], [2, 10, 4, 2, 1])[0]
    # Copying thousands of links for a change that hardly matters would only take time.
    as_elements = 0 if len(text) > 100_000 else count
    damaged_text = rng.random() < 0.15
    if beside:
        for name in beside:
            if count and rng.random() < 0.7:
                steps.append(f"break {name}")
                change = break_yaml if name.endswith(("yaml", "yml")) else break_text
                beside[name] = change(rng, beside[name])
        as_elements = as_elements if not steps or rng.random() < 0.3 else 0
    if as_elements and not (damaged_text and count == 1):
        root = ElementTree.fromstring(text)
        steps += [break_elements(rng, root) for _ in range(as_elements)]
        text = ElementTree.tostring(root, encoding="unicode")
    if count and damaged_text:
        steps.append("text")
        text = break_text(rng, text)
    name = start.name
    if name is None and rng.random() < 0.1:
        name = "model.xml" if text.startswith("<mujoco") else "robot.urdf"
    encoding = "utf-16" if name is not None and rng.random() < 0.01 else "utf-8"
    strict = rng.random() < 0.8
    return Case(text, name, beside, encoding, strict, start.drives, dict(start.held), tuple(steps))
