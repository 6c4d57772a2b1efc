"""Change the rules, one operator, constant or branch at a time, and see that a test notices each change: `make mutate`.

A mutant is one such change in one of the modules below. It is made in memory, in a process of its own that runs
the tests without the compiler (NUMBA_DISABLE_JIT=1) until one fails; the files stay as they are. Tests that do not call
the changed function cannot notice it, and are not asked. Mutants that no test can notice stand in
tests/mutation/equivalent.toml, each with its reason; every other one must be noticed, and an entry there that fits no
mutant fails the run too. Those listed are not tried, since each would take all the tests that there are: half of the
time. `--equivalents` tries them alone, and fails for each that a test notices. Needs os.fork: Linux or macOS.
"""

import argparse
import ast
import copy
import importlib.abc
import importlib.util
import inspect
import itertools
import json
import math
import os
import re
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

from catch_arena.cli.progress import progress_bar
from catch_arena.files import tomllib

ROOT = Path(__file__).parent.parent
CORE = ROOT / "catch_arena" / "core"
MODULES = (
    "arbiter",
    "catching",
    "controllers",
    "dropouts",
    "features",
    "physics",
    "prey",
    "prey_views",
    "ranking",
    "rewards",
    "spawner",
    "targets",
    "tiles",
    "visibility",
)
EQUIVALENT = ROOT / "tests" / "mutation" / "equivalent.toml"

MATCHES = "tests/properties/test_engine_equals_oracle.py::test_engine_and_oracle_play_the_same_matches"
KILLERS = (
    "tests/unit/test_arbiter.py",
    "tests/unit/test_controllers.py",
    "tests/unit/test_physics.py",
    "tests/unit/test_ranking.py",
    "tests/unit/test_targets.py",
    "tests/unit/test_visibility.py",
    f"{MATCHES}[0]",
    "tests/conformance/test_adjudicators.py::test_an_arena_of_ours_answers_every_case_that_it_can_play[engine]",
    "tests/rulebook/test_ch4_control.py",
    "tests/rulebook/test_ch5_arbiter.py",
    "tests/rulebook",
    "tests/properties/test_rows_apart.py",
    "tests/properties/test_batch.py",
    "tests/unit/test_engine.py",
)
"""What the tests are asked, the quickest to notice a change first."""
OWN_TESTS = {
    "catching": ("test_rows_apart",),
    "controllers": ("test_rows_apart",),
    "prey": ("test_ch12_prey", "test_rows_apart"),
    "prey_views": ("test_ch12_prey", "test_rows_apart"),
    "ranking": ("test_ranking",),
    "rewards": ("test_ch6_score", "test_ch11_teams", "test_rows_apart"),
}
"""Of a module, by their files' names: they are asked before all others. Unit tests need not be named here."""
SLOW = "[batch or 70 or another_engine or oldest or 60_s or first_fires or process or interpreted"
"""Tests that notice nothing that others do not notice sooner."""
LONGEST_TEST_S = 90
"""CPU time; without the compiler the random matches take 20 s, and none of the others 10 s."""
TIMES_SLOWER, SPARE_S = 5, 5
"""How much longer a test may take on a mutant, where it is known how long it takes on the core as it is."""

OTHER_COMPARISONS: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.NotEq, ast.Eq, ast.GtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Eq, ast.NotEq, ast.Gt, ast.GtE),
    ast.Gt: (ast.GtE, ast.NotEq, ast.Eq, ast.LtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Eq, ast.NotEq, ast.Lt, ast.LtE),
    ast.Eq: (ast.NotEq, ast.LtE, ast.GtE),
    ast.NotEq: (ast.Eq, ast.Lt, ast.Gt),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OTHER_OPERATORS: dict[type[ast.operator], tuple[type[ast.operator], ...]] = {
    ast.Add: (ast.Sub, ast.Mult),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div, ast.Add),
    ast.Div: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,),
    ast.BitOr: (ast.BitAnd,),
    ast.LShift: (ast.RShift,),
    ast.RShift: (ast.LShift,),
}
NOT_CALCULATED = frozenset({"annotation", "returns", "decorator_list", "body", "orelse"})
"""Fields of a statement that hold other statements, or what is never calculated."""


@dataclass(frozen=True)
class Name:
    """What a mutant is called: by its text, so that it keeps its name when lines move."""

    function: str
    """`module.function`, or `module` alone for a constant."""
    line: str
    """The statement, or the head of an `if`, `for` or `while`, as `ast.unparse` writes it."""
    becomes: str
    nth: int
    """From 1: which of those of a function that read alike."""

    def __str__(self) -> str:
        which = f" (number {self.nth})" if self.nth > 1 else ""
        return f"{self.function}{which}\n  - {self.line}\n  + {self.becomes}"


@dataclass(frozen=True)
class Mutant:
    """One change, ready to be made."""

    name: Name
    module: str
    function: str
    """Empty for a constant of the module."""
    code: CodeType
    """The whole module's."""


# ---- what can be changed ----


def is_constant(name: str) -> bool:
    """Whether a name is written as constants are."""
    return re.fullmatch(r"_?[A-Z][A-Z0-9_]*", name) is not None


def added(node: ast.expr, number: int) -> ast.expr:
    """The expression and a whole number more."""
    operator = ast.Add() if number > 0 else ast.Sub()
    return ast.BinOp(copy.deepcopy(node), operator, ast.Constant(abs(number)))


def alternatives(node: ast.expr) -> Iterator[ast.expr]:
    """What may stand in the place of one expression, its parts apart."""
    match node:
        case ast.Compare(left=left, ops=[operator], comparators=[right]):
            for other in OTHER_COMPARISONS[type(operator)]:
                yield ast.Compare(left, [other()], [right])
        case ast.BinOp(left=left, op=operator, right=right):
            for another in OTHER_OPERATORS.get(type(operator), ()):
                yield ast.BinOp(left, another(), right)
        case ast.BoolOp(op=operator, values=values):
            yield ast.BoolOp(ast.Or() if isinstance(operator, ast.And) else ast.And(), values)
            yield from values
        case ast.UnaryOp(operand=operand):
            yield operand
        case ast.IfExp(body=body, orelse=orelse) | ast.Call(func=ast.Name(id="select"), args=[_, body, orelse]):
            yield body
            yield orelse
        case ast.Constant(value=bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(value=int(value) | float(value)):
            yield ast.Constant(value + 1)
            yield ast.Constant(value - 1)
        case ast.Name(id=name, ctx=ast.Load()) if is_constant(name):
            yield added(node, 1)


@dataclass(frozen=True)
class Place:
    """Where a node hangs: a field of its parent, or an item of a list there."""

    parent: ast.AST
    field: str
    index: int | None = None

    def put(self, node: ast.AST) -> None:
        """Hang another node there."""
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node


def below(parent: ast.AST) -> Iterator[tuple[Place, ast.AST]]:
    """All that a statement calculates with, and where it hangs; not the statements within."""
    for field, value in ast.iter_fields(parent):
        if field in NOT_CALCULATED and isinstance(parent, ast.stmt):
            continue
        children = (
            [(Place(parent, field, i), item) for i, item in enumerate(value)]
            if isinstance(value, list)
            else [(Place(parent, field), value)]
        )
        for place, child in children:
            if isinstance(child, ast.AST):
                yield place, child
                yield from below(child)


def changes(statement: ast.stmt) -> Iterator[tuple[Place, ast.AST, ast.AST]]:
    """Every change of one statement: where, what was there, and what is to be."""
    if isinstance(statement, ast.If):
        for always in (True, False):
            yield Place(statement, "test"), statement.test, ast.Constant(always)
    elif isinstance(statement, ast.While):  # one that is always true never ends
        yield Place(statement, "test"), statement.test, ast.Constant(value=False)
    elif isinstance(statement, ast.AugAssign):
        for other in OTHER_OPERATORS[type(statement.op)]:
            yield Place(statement, "op"), statement.op, other()
    elif isinstance(statement, ast.AnnAssign) and isinstance(statement.value, ast.Call):
        for number in (1, -1):
            yield Place(statement, "value"), statement.value, added(statement.value, number)
    for place, node in below(statement):
        if isinstance(node, ast.expr):
            for other_expression in alternatives(node):
                yield place, node, other_expression


def statements(tree: ast.Module) -> Iterator[tuple[str, ast.stmt]]:
    """Every statement that calculates something, with the name of the function that it stands in."""
    for top in tree.body:
        if isinstance(top, ast.FunctionDef):
            for node in ast.walk(top):
                if isinstance(node, ast.stmt) and node is not top:
                    yield top.name, node
        elif isinstance(top, ast.AnnAssign | ast.Assign):
            yield "", top


def mutants_of(module: str) -> Iterator[Mutant]:
    """All mutants of a module of the core."""
    path = CORE / f"{module}.py"
    tree = ast.parse(path.read_text(encoding="utf-8"))
    met: Counter[tuple[str, str, str]] = Counter()
    for function, statement in statements(tree):
        line = ast.unparse(statement).splitlines()[0]
        for place, node, other in changes(statement):
            place.put(other)
            becomes = ast.unparse(statement).splitlines()[0]
            code = compile(ast.fix_missing_locations(tree), path, "exec")
            place.put(node)
            if becomes == line:  # a number so large that one more is the same
                continue
            where = f"{module}.{function}" if function else module
            met[where, line, becomes] += 1
            yield Mutant(Name(where, line, becomes, met[where, line, becomes]), module, function, code)


# ---- whether it is noticed ----


class OneMutant(importlib.abc.MetaPathFinder, SourceFileLoader):
    """Imports one mutant in the place of its module."""

    def __init__(self, mutant: Mutant) -> None:
        super().__init__(f"catch_arena.core.{mutant.module}", str(CORE / f"{mutant.module}.py"))
        self.mutant = mutant

    def find_spec(self, fullname: str, *_: object) -> ModuleSpec | None:
        """Of the mutated module alone."""
        return importlib.util.spec_from_loader(fullname, self) if fullname == self.name else None

    def get_code(self, fullname: str) -> CodeType:  # noqa: ARG002 - a loader's signature
        """The mutant's."""
        return self.mutant.code


def put_in_place(mutant: Mutant) -> None:
    """A function's new code, for whoever has imported it; a module's, for whoever is going to."""
    if mutant.function:
        replace(mutant.module, mutant.function, mutant.code)
    else:
        sys.meta_path.insert(0, OneMutant(mutant))


def replace(name: str, function: str, code: CodeType) -> None:
    """Give one function of a module the code that it has in another state of the whole module."""
    codes = (constant for constant in code.co_consts if isinstance(constant, CodeType))
    module = importlib.import_module(f"catch_arena.core.{name}")
    inspect.unwrap(getattr(module, function)).__code__ = next(one for one in codes if one.co_name == function)


def note_calls(name: str, called: set[str]) -> None:
    """Let every function of a module add `module.function` to `called` whenever it is called."""
    path = CORE / f"{name}.py"
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = [top for top in tree.body if isinstance(top, ast.FunctionDef)]
    for function in functions:
        function.body[:0] = ast.parse(f"__called__.add({name + '.' + function.name!r})").body
    code = compile(ast.fix_missing_locations(tree), path, "exec")
    vars(importlib.import_module(f"catch_arena.core.{name}"))["__called__"] = called
    for function in functions:
        replace(name, function.name, code)


def allow(seconds: float) -> None:
    """End this process where it takes longer: some mutants never end. CPU time, since the machine may be busy."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(time.process_time() + seconds), resource.RLIM_INFINITY))


class Hourglass:
    """A plugin of pytest that ends the process where a test takes too long."""

    def pytest_runtest_setup(self) -> None:
        """Before each test."""
        allow(LONGEST_TEST_S)


def turn_of(path: Path, mutant: Mutant) -> int:
    """When tests are asked about a mutant: those of its module first, and last the unit tests of others, which rarely
    notice it.
    """
    if path.stem in (f"test_{mutant.module}", *OWN_TESTS.get(mutant.module, ())):
        return 0
    return 2 if path.parent.name == "unit" else 1


class OnEveryMutant:
    """A plugin of pytest that runs the tests, once they are collected, on one mutant after the other: those that call
    its function, and first of all those to which a notice of the same function's mutants has cost the least time.
    """

    def __init__(self, mutants: Sequence[Mutant], processes: int, found: list[Name]) -> None:
        self.mutants = mutants
        self.processes = processes
        self.found = found

    def pytest_runtestloop(self, session: Any) -> bool:
        """In the place of pytest's own loop."""
        import pytest

        def passes(item: Any, following: Any) -> bool:
            session.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
            return not session.testsfailed

        def run_all() -> int:
            called: set[str] = set()
            for module in {mutant.module for mutant in self.mutants}:
                note_calls(module, called)
            for item, following in itertools.zip_longest(session.items, session.items[1:]):
                called.clear()
                started = time.process_time()
                if not passes(item, following):
                    print(item.nodeid)
                    return 1
                print(json.dumps([sorted(called), time.process_time() - started]), file=notes, flush=True)
            return 0

        def run_callers(mutant: Mutant) -> int:
            function = mutant.name.function
            spent, notices = Counter[str](), Counter[str]()
            for line in Path(notes.name).read_text(encoding="utf-8").splitlines():
                if line.startswith(f'["{function}"'):
                    _, test, seconds, noticed = json.loads(line)
                    spent[test] += seconds
                    notices[test] += noticed

            def cost(item: Any) -> float:
                return spent[item.nodeid] / notices[item.nodeid] if notices[item.nodeid] else math.inf

            callers = [(item, seconds) for item, (called, seconds) in known if function in called]
            callers.sort(key=lambda one: (cost(one[0]), turn_of(one[0].path, mutant)))
            for (item, seconds), following in itertools.zip_longest(callers, callers[1:]):
                allow(SPARE_S + TIMES_SLOWER * seconds)
                begun = time.process_time()
                noticed = not passes(item, following and following[0])
                print(json.dumps([function, item.nodeid, time.process_time() - begun, noticed]), file=notes, flush=True)
                if noticed:
                    return 1
            return 0

        with tempfile.NamedTemporaryFile("w+", encoding="utf-8") as notes:
            if os.waitpid(begin(run_all), 0)[1] != 0:
                pytest.exit("the core as it is fails the tests", returncode=1)
            notes.seek(0)
            known = list(zip(session.items, map(json.loads, notes), strict=True))
            self.found += survivors(self.mutants, self.processes, run_callers)
        return True


def on_constants(mutant: Mutant) -> int:
    """What pytest says of the killing tests, in a process that has none of the core yet: first of those of the mutant's
    module, which are collected in a fraction of the time.
    """
    own = [tests for tests in KILLERS if turn_of(ROOT / tests, mutant) == 0]
    return run_pytest(Hourglass(), own) or run_pytest(Hourglass())


def run_pytest(plugin: object, tests: Sequence[str] = KILLERS) -> int:
    """What pytest says of these tests, up to the first that fails."""
    import pytest

    options = ("-x", "-q", "--capture=no", "-p", "no:cacheprovider", "--assert=plain", "-k", f"not ({SLOW})")
    return int(pytest.main([*options, *tests], [plugin])) if tests else 0


def begin(run: Callable[[], int]) -> int:
    """A process that runs tests and ends with 0 if they all pass."""
    if (process := os.fork()) != 0:
        return process
    code = 1
    try:
        code = run()
    finally:
        os._exit(code)  # nothing may come back into the copy of this script


def survivors(mutants: Sequence[Mutant], processes: int, run_tests: Callable[[Mutant], int]) -> list[Name]:
    """Those on which all tests pass."""

    def try_out(mutant: Mutant) -> int:
        nowhere = os.open(os.devnull, os.O_RDWR)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        put_in_place(mutant)
        return run_tests(mutant)

    running: dict[int, Mutant] = {}
    found = []
    done = 0
    waiting = iter(mutants)
    with progress_bar("mutants", len(mutants)) as show:
        while True:
            for mutant in itertools.islice(waiting, processes - len(running)):
                running[begin(partial(try_out, mutant))] = mutant
            if not running:
                return found
            process, status = os.wait()
            mutant = running.pop(process)
            done += 1
            show(done, len(mutants))
            if status == 0:
                print(f"no test notices: {mutant.name}", file=sys.stderr)
                found.append(mutant.name)


def known_equivalents() -> list[Name]:
    """What tests/mutation/equivalent.toml lists."""
    entries = tomllib.loads(EQUIVALENT.read_text(encoding="utf-8"))["equivalent"]
    return [
        Name(entry["function"], entry["line"], becomes, entry.get("nth", 1))
        for entry in entries
        for becomes in entry["becomes"]
    ]


def main() -> None:
    """Ends with 1 where a mutant that is not listed as equivalent survives, or the list is out of date."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="TEXT", help="mutants whose name or text contains this")
    parser.add_argument("--module", action="append", choices=MODULES, help="those of this module; may be given again")
    parser.add_argument(
        "--equivalents", action="store_true", help="try those that are listed as equivalent, and no others"
    )
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="how many mutants are tried at a time")
    options = parser.parse_args()
    modules: Sequence[str] = options.module or MODULES

    def asked_for(name: Name) -> bool:
        return options.only in str(name) and name.function.partition(".")[0] in modules

    os.chdir(ROOT)
    os.environ |= {"NUMBA_DISABLE_JIT": "1", "OPENBLAS_NUM_THREADS": "1"}
    import gymnasium  # noqa: F401 - loaded once, for all processes
    import hypothesis.strategies  # noqa: F401
    import numba  # noqa: F401
    import pettingzoo  # noqa: F401
    import pytest  # noqa: F401

    started = time.monotonic()
    possible = [mutant for module in modules for mutant in mutants_of(module) if asked_for(mutant.name)]
    listed = [name for name in known_equivalents() if asked_for(name)]
    mutants = [mutant for mutant in possible if (mutant.name in listed) == options.equivalents]
    # constants first: collecting the tests for all the others imports the modules here, for good
    found = survivors([mutant for mutant in mutants if not mutant.function], options.processes, on_constants)
    within = [mutant for mutant in mutants if mutant.function]
    if within and run_pytest(OnEveryMutant(within, options.processes, found)):
        sys.exit(1)

    alive = set(found)
    if options.equivalents:
        noticed = [mutant.name for mutant in mutants if mutant.name not in alive]
        complaints = [f"listed as equivalent, but a test notices it: {name}" for name in noticed]
    else:
        complaints = [f"no test notices: {name}" for name in found]
    names = {mutant.name for mutant in possible}
    complaints += [f"listed as equivalent, but there is no such mutant: {name}" for name in listed if name not in names]
    complaints += [f"listed twice: {name}" for name, count in Counter(listed).items() if count > 1]
    for complaint in complaints:
        print(complaint)
    minutes = (time.monotonic() - started) / 60
    print(
        f"{len(mutants)} mutants in {minutes:.1f} minutes: {len(mutants) - len(alive)} noticed, {len(alive)} not; "
        f"{len(listed)} are listed as equivalent"
    )
    sys.exit(1 if complaints else 0)


if __name__ == "__main__":
    main()
