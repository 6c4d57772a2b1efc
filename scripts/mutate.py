"""Change the rules, one operator, number or branch at a time, and check that a test notices each change: `make mutate`.

A mutant is one such change in a function of catch_arena/core. It is made in memory, in a process of its own that runs
tests without the compiler until one fails. Tests that do not call the function cannot notice it, and are left out.
tests/mutation/equivalent.toml has the modules, the tests, and the mutants that no test can notice, each with its
reason. Those mutants are not tried, and an entry that fits no mutant is an error. Needs os.fork: Linux or macOS.
"""

import argparse
import ast
import importlib
import inspect
import multiprocessing
import os
import re
import signal
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Any

from catch_arena.cli.progress import progress_bar
from catch_arena.files import tomllib

ROOT = Path(__file__).parent.parent
SETTINGS = tomllib.loads((ROOT / "tests" / "mutation" / "equivalent.toml").read_text(encoding="utf-8"))
OTHERS: dict[type[ast.AST], tuple[type[Any], ...]] = {
    ast.Lt: (ast.LtE, ast.NotEq, ast.Eq, ast.GtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.Eq, ast.NotEq, ast.Gt, ast.GtE),
    ast.Gt: (ast.GtE, ast.NotEq, ast.Eq, ast.LtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.Eq, ast.NotEq, ast.Lt, ast.LtE),
    ast.Eq: (ast.NotEq, ast.LtE, ast.GtE),
    ast.NotEq: (ast.Eq, ast.Lt, ast.Gt),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
    ast.Add: (ast.Sub, ast.Mult),
    ast.Sub: (ast.Add,),
    ast.Mult: (ast.Div, ast.Add),
    ast.Div: (ast.Mult,),
    ast.BitAnd: (ast.BitOr,),
    ast.BitOr: (ast.BitAnd,),
    ast.LShift: (ast.RShift,),
    ast.RShift: (ast.LShift,),
}
Mutant = tuple[str, str, str, int]
"""Mutant, named by its text, so that it keeps its name when lines move: `module.function`, the statement's first
line, its replacement, and its number, from 1, among mutants of the function with the same text.
"""


def shown(mutant: Mutant) -> str:
    """Return the text of a mutant that is printed and that `--only` matches."""
    function, line, becomes, nth = mutant
    return f"{function}{f' (number {nth})' if nth > 1 else ''}\n  - {line}\n  + {becomes}"


def changes(node: ast.AST) -> Iterator[tuple[ast.AST, ast.AST]]:
    """Yield the changes of one node, without those of its parts: the old node and the new one."""
    one = ast.Constant(1)
    match node:
        case ast.If(test=test):
            yield from ((test, ast.Constant(always)) for always in (True, False))
        case ast.While(test=test):  # a loop whose condition is always true never ends
            yield test, ast.Constant(value=False)
        case ast.AnnAssign(value=ast.Call() as call):
            yield from ((call, ast.BinOp(call, operator, one)) for operator in (ast.Add(), ast.Sub()))
        case ast.AugAssign(target, operator, value):
            yield from ((node, ast.AugAssign(target, other(), value)) for other in OTHERS[type(operator)])
        case ast.Compare(left, [operator], [right]):
            yield from ((node, ast.Compare(left, [other()], [right])) for other in OTHERS[type(operator)])
        case ast.BinOp(left, operator, right):
            yield from ((node, ast.BinOp(left, other(), right)) for other in OTHERS.get(type(operator), ()))
        case ast.BoolOp(operator, values):
            yield node, ast.BoolOp(ast.Or() if isinstance(operator, ast.And) else ast.And(), values)
            yield from ((node, value) for value in values)
        case ast.UnaryOp(operand=operand):
            yield node, operand
        case ast.IfExp(body=body, orelse=orelse) | ast.Call(func=ast.Name(id="select"), args=[_, body, orelse]):
            yield from ((node, body), (node, orelse))
        case ast.Constant(bool(value)):
            yield node, ast.Constant(not value)
        case ast.Constant(int(value) | float(value)):
            yield from ((node, ast.Constant(value + 1)), (node, ast.Constant(value - 1)))
        case ast.Name(id=name, ctx=ast.Load()) if re.fullmatch(r"_?[A-Z][A-Z0-9_]*", name):
            yield node, ast.BinOp(node, ast.Add(), one)


def parts(statement: ast.stmt) -> Iterator[ast.AST]:
    """Yield a statement and its expressions, without its annotation and the statements within it."""
    yield statement
    for name, value in ast.iter_fields(statement):
        if name not in {"annotation", "body", "orelse"}:
            for child in value if isinstance(value, list) else [value]:
                yield from ast.walk(child) if isinstance(child, ast.AST) else ()


def swap(function: ast.FunctionDef, old: ast.AST, new: ast.AST) -> None:
    """Put one node of a function in the place of another."""
    transformer = ast.NodeTransformer()
    transformer.visit = lambda node: new if node is old else transformer.generic_visit(node)  # type: ignore[method-assign]
    transformer.visit(function)


def functions_of(module: str) -> list[ast.FunctionDef]:
    """Return the functions of a module of the core."""
    source = (ROOT / "catch_arena" / "core" / f"{module}.py").read_text(encoding="utf-8")
    return [one for one in ast.parse(source).body if isinstance(one, ast.FunctionDef)]


def compiled(function: ast.FunctionDef) -> CodeType:
    """Return the code of a function."""
    whole = compile(ast.fix_missing_locations(ast.Module([function], [])), function.name, "exec")
    return next(one for one in whole.co_consts if isinstance(one, CodeType))


def mutants_of(module: str) -> Iterator[tuple[Mutant, CodeType]]:
    """Yield all mutants of a module of the core, with the function's code."""
    met: Counter[tuple[str, str, str]] = Counter()
    for function in functions_of(module):
        for statement in [one for one in ast.walk(function) if isinstance(one, ast.stmt) and one is not function]:
            line = ast.unparse(statement).splitlines()[0]
            for old, new in [change for part in parts(statement) for change in changes(part)]:
                swap(function, old, new)
                becomes = ast.unparse(new if old is statement else statement).splitlines()[0]
                code = compiled(function)
                swap(function, new, old)
                if becomes != line:  # one more than a large number may be the same number
                    name = f"{module}.{function.name}", line, becomes
                    met[name] += 1
                    yield (*name, met[name]), code


def function_of(name: str) -> Any:
    """Return a function of the core, without its decorators."""
    module, function = name.split(".")
    return inspect.unwrap(getattr(importlib.import_module(f"catch_arena.core.{module}"), function))


class Trial:
    """A plugin of pytest that runs the collected tests on one mutant after the other, each in a process of its own."""

    def __init__(self, codes: dict[Mutant, CodeType]) -> None:
        self.codes = codes
        self.survivors: list[Mutant] = []

    def pytest_runtestloop(self, session: Any) -> bool:
        """Run all tests once on the core as it is, then on each mutant those that call its function."""
        global trial
        trial, self.items, total = self, session.items, len(self.codes)
        fork = multiprocessing.get_context("fork")
        with fork.Pool(1) as pool:
            self.known = pool.apply(run_all)
        with progress_bar("mutants", total) as show, fork.Pool(maxtasksperchild=1) as pool:
            for done, (mutant, noticed) in enumerate(zip(self.codes, pool.imap(is_noticed, self.codes), strict=True)):
                show(done + 1, total)
                if not noticed:
                    print(f"no test notices: {shown(mutant)}", file=sys.stderr)
                    self.survivors.append(mutant)
        return True


trial: Trial
"""Trial of this process; the processes of its pools are forked, and have it too."""


def passes(item: Any) -> bool:
    """Run one test, and return whether it passes; no fixture is kept for the next test."""
    item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
    return not item.session.testsfailed


def run_all() -> list[tuple[set[str], float]]:
    """Run all tests on the unchanged core; return the functions that each calls, and its processor time [s]."""
    called: set[str] = set()
    for module in {mutant[0].partition(".")[0] for mutant in trial.codes}:
        for function in functions_of(module):
            name = f"{module}.{function.name}"
            function.body.insert(0, ast.parse(f"_called.add({name!r})").body[0])
            function_of(name).__code__ = compiled(function)
            function_of(name).__globals__["_called"] = called
    found = []
    for item in trial.items:
        called.clear()
        begun = time.process_time()
        if not passes(item):
            raise RuntimeError(f"the core as it is fails {item.nodeid}; mend that first")
        found.append((set(called), time.process_time() - begun))
    return found


def is_noticed(mutant: Mutant) -> bool:
    """Make a mutant, and return whether a test notices it; tests that take less time run first."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    signal.signal(signal.SIGVTALRM, signal.default_int_handler)  # KeyboardInterrupt: no test catches it
    function_of(mutant[0]).__code__ = trial.codes[mutant]
    callers = [(s, place) for place, (called, s) in enumerate(trial.known) if mutant[0] in called]
    for seconds, place in sorted(callers):
        signal.setitimer(signal.ITIMER_VIRTUAL, 5 + 5 * seconds)  # of processor time, since some mutants never end
        try:
            if not passes(trial.items[place]):
                return True
        except KeyboardInterrupt:
            return True
    return False


def main() -> None:
    """Try the mutants; exit with 1 if one that is not listed survives, or if the list is out of date."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", default="", metavar="TEXT", help='mutants whose name or text contains this ("prey.")')
    parser.add_argument("--equivalents", action="store_true", help="try only the mutants that are listed as equivalent")
    options = parser.parse_args()
    os.chdir(ROOT)
    os.environ |= {"NUMBA_DISABLE_JIT": "1", "OPENBLAS_NUM_THREADS": "1"}
    import pytest  # after the settings that its plugins and the core read when they load

    entries = SETTINGS["equivalent"]
    listed = [(one["function"], one["line"], text, one.get("nth", 1)) for one in entries for text in one["becomes"]]
    listed = [one for one in listed if options.only in shown(one)]
    made = [one for module in SETTINGS["modules"] for one in mutants_of(module)]
    possible = {mutant: code for mutant, code in made if options.only in shown(mutant)}
    plugin = Trial({one: code for one, code in possible.items() if (one in listed) == options.equivalents})
    flags = ("-x", "-q", "--capture=no", "-p", "no:cacheprovider", "--assert=plain", "-k", SETTINGS["without"])
    if plugin.codes and pytest.main([*flags, *SETTINGS["tests"]], [plugin]) != 0:
        sys.exit(1)
    wrong = [f"listed, but there is no such mutant: {shown(one)}" for one in listed if one not in possible]
    if options.equivalents:
        noticed = plugin.codes.keys() - plugin.survivors
        wrong += [f"listed, but a test notices it: {shown(one)}" for one in plugin.codes if one in noticed]
    else:
        wrong += [f"no test notices: {shown(one)}" for one in plugin.survivors]
    print(*wrong, sep="\n")
    print(f"{len(plugin.codes)} mutants: {len(plugin.survivors)} not noticed; {len(listed)} are listed as equivalent")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
