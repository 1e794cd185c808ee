"""Which joints carry links, and which close loops."""

from __future__ import annotations

import numpy as np
import pytest

from cardan_dyn.practice.formats.sdf.joints import Edge, spanning_tree


def edge(words: str) -> Edge:
    """Return the joint of `name parent child`, fixed with an f before, cut with a c."""
    name, parent, child = words.split()
    kind = "fixed" if name.startswith("f") else "revolute"
    return Edge(name, kind, parent, child, np.eye(4), is_cut=name.startswith("c"))


def spanned(*words: str, links: str = "ABC", canonical: str = "A") -> tuple[str, str, str]:
    """Return names of the tree's joints as reached, of the links that float, of the loops."""
    tree = spanning_tree(links, canonical, [edge(item) for item in words])
    joints = " ".join(f"{item.name}{'*' * is_reversed}" for item, is_reversed in tree.joints)
    return joints, " ".join(tree.floating), " ".join(item.name for item in tree.loops)


@pytest.mark.parametrize(
    ("words", "found"),
    [
        # A link with two parents: the first joint in the file carries it.
        (["a world A", "b A B", "d world C", "c B C"], ("a b d", "", "c")),
        (["a world A", "b A B", "k B C", "d world C"], ("a b k", "", "d")),
        (["k B C", "d world C", "b A B", "a world A"], ("d a b", "", "k")),
        # The author's cut.
        (["a world A", "b A B", "cut B C", "d world C"], ("a b d", "", "cut")),
        (["a world A", "b A B", "cut B C"], ("a b", "C", "cut")),
        # No chain of joints leads to B: it floats.
        (["a world A", "b B A", "k B C"], ("a k", "B", "b")),
        # A free model, its root first or last.
        (["a A B", "b B C"], ("a b", "A", "")),
        (["a C B", "b B A"], ("a b", "C", "")),
        # A ring without any beginning: the canonical link.
        (["a A B", "b B C", "k C A"], ("a b", "A", "k")),
        # Fixed joints carry their parents as well.
        (["a world A", "f1 B A", "f2 B C"], ("a f1* f2", "", "")),
        (["f1 B A", "f2 C B"], ("f1* f2*", "A", "")),
        # The fixed ones make one body, which another link carries.
        (["f1 B A", "a C B"], ("a f1", "C", "")),
        # Two mechanisms that hang together nowhere.
        (["a A B"], ("a", "A C", "")),
    ],
)
def test_trees(words: list[str], found: tuple[str, str, str]) -> None:
    assert spanned(*words) == found


def test_the_canonical_link_floats_if_it_can() -> None:
    assert spanned("f1 A B", "a B C", canonical="B")[1] == "B"
    assert spanned("f1 A B", "a B C", canonical="C")[1] == "A"
    assert spanned("a A B", "b B C", "k C A", canonical="B") == ("b k", "B", "a")


def test_a_long_chain() -> None:
    links = [f"l{index}" for index in range(2000)]
    joints = [edge(f"j{index} l{index} l{index + 1}") for index in range(1999)]
    tree = spanning_tree(links, "l0", [edge("a world l0"), *joints[::-1]])
    assert len(tree.joints) == 2000
    assert not tree.loops
