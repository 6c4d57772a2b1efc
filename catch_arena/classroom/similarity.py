"""Submissions that are equal or nearly equal: a reason to look at them, never a mark.

Python's syntax trees are compared without names, comments, texts, numbers and layout. What most of the class has, such
as the code of the exercise, is left out, and what `new-agent` writes.
"""

import ast
import warnings
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final, NamedTuple

from catch_arena.classroom.starters import kit_programs
from catch_arena.classroom.submissions import Submission
from catch_arena.tournament.agent_spec import content_of

_NODES: Final = 8
"""Number of nodes in a row that are compared as one piece."""
_LEAST: Final = 40
"""Smallest number of pieces that are compared: shorter agents are similar by chance."""
_ALIKE: Final = 0.5
"""Smallest share of common pieces, in [0, 1], that is reported."""
_COMMON: Final = 3
"""Number of submissions, but not all, that may have a piece in any class; in a large class, half of it may."""
_LONGEST: Final = 1 << 20
"""Largest size of a file that is compared [bytes]."""

Shape = frozenset[tuple[str, ...]]
"""Pieces of a syntax tree: the kinds of some nodes in a row."""


class Pair(NamedTuple):
    """Two submissions to look at."""

    first: str
    second: str
    share: float
    """Share of the common pieces in all pieces of both, in [0, 1]; 1.0 also for equal files."""
    equal: bool
    """True if their files are equal, byte by byte."""

    def __str__(self) -> str:
        """Return the reason to look at them."""
        return "equal files" if self.equal else f"{100 * self.share:.0f} % of the code has the same structure"


def similar_pairs(submissions: Sequence[Submission]) -> list[Pair]:
    """Return the pairs of submissions that are equal or nearly equal, the most similar first; empty ones have none."""
    submissions = [one for one in submissions if one.files]
    digests = {one.name: one.digest() for one in submissions}
    kit = Shape().union(*map(_pieces, kit_programs()))
    shapes = {one.name: _shape(one) - kit for one in submissions}
    owners = Counter(piece for shape in shapes.values() for piece in shape)
    most = max(2, min(_COMMON, len(submissions) - 1), len(submissions) // 2)
    own = {name: frozenset(piece for piece in shape if owners[piece] <= most) for name, shape in shapes.items()}
    pairs = []
    for first, second in combinations(digests, 2):
        equal = digests[first] == digests[second]
        either = own[first] | own[second]
        share = len(own[first] & own[second]) / len(either) if min(len(own[first]), len(own[second])) >= _LEAST else 0.0
        if equal or share >= _ALIKE:
            pairs.append(Pair(first, second, 1.0 if equal else share, equal))
    return sorted(pairs, key=lambda pair: (-pair.equal, -pair.share))


def _shape(submission: Submission) -> Shape:
    programs = (content_of(str(path)) for path in submission.files if path.suffix.lower() == ".py")
    return Shape().union(*(_pieces(one) for one in programs if one is not None and len(one) <= _LONGEST))


def _pieces(program: bytes) -> Shape:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a student's escapes in texts
            kinds = list(_kinds(ast.parse(program)))
    except (SyntaxError, ValueError, RecursionError, MemoryError):  # it is no Python, and cannot play either
        return frozenset()
    return frozenset(zip(*(kinds[offset:] for offset in range(_NODES)), strict=False))


def _kinds(tree: ast.AST) -> Iterator[str]:
    """Yield the kinds of the nodes in the order of the source, without docstrings and types."""
    left = [tree]
    while left:
        node = left.pop()
        if isinstance(node, ast.expr_context) or (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)):
            continue
        yield type(node).__name__
        types = {id(getattr(node, "annotation", None)), id(getattr(node, "returns", None))}
        left += [child for child in reversed([*ast.iter_child_nodes(node)]) if id(child) not in types]
