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
from collections.abc import Iterator
from pathlib import Path
from types import CodeType
from typing import Any

from catch_arena.cli.terminal import progress_bar
from catch_arena.files import tomllib

ROOT = Path(__file__).parent.parent
SETTINGS = tomllib.loads((ROOT / "tests" / "mutation" / "equivalent.toml").read_text(encoding="utf-8"))
COMPARISONS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)
OTHERS: dict[type[ast.AST], tuple[type[Any], ...]] = {
    **{one: tuple(other for other in COMPARISONS if other is not one) for one in COMPARISONS[:4]},
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
}
codes: dict[str, CodeType] = {}
"""Code of the changed function of each mutant to try, by the mutant's name."""
tests: list[Any] = []
calls: list[tuple[float, int, set[str]]] = []
"""Processor time [s] of each test, its place in `tests`, and the functions of the core that it calls."""


def name_of(function: str, line: str, becomes: str, nth: int) -> str:
    """Return the name of a mutant: `module.function`, first line of the statement, its replacement, and its number,
    from 1, among mutants of the function with the same text. The name stays if lines move.
    """
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


def swap(function: ast.FunctionDef, old: ast.AST, new: ast.AST) -> None:
    """Put one node of a function in the place of another."""
    transformer = ast.NodeTransformer()
    transformer.visit = lambda node: new if node is old else transformer.generic_visit(node)  # type: ignore[method-assign]
    transformer.visit(function)


def compiled(function: ast.FunctionDef) -> CodeType:
    """Return the code of a function."""
    whole = compile(ast.fix_missing_locations(ast.Module([function], [])), function.name, "exec")
    return next(one for one in whole.co_consts if isinstance(one, CodeType))


def mutants_of(module: str) -> Iterator[tuple[str, CodeType]]:
    """Yield the names of all mutants of a module of the core, with the function's code."""
    met: dict[tuple[str, str, str], int] = {}
    source = (ROOT / "catch_arena" / "core" / f"{module}.py").read_text(encoding="utf-8")
    for function in [one for one in ast.parse(source).body if isinstance(one, ast.FunctionDef)]:
        statements = [one for one in ast.walk(function) if isinstance(one, ast.stmt)]  # outer ones first
        statement_of = {part: statement for statement in statements for part in ast.walk(statement)}
        for old, new, statement in [(*change, at) for part, at in statement_of.items() for change in changes(part)]:
            line = ast.unparse(statement).splitlines()[0]
            swap(function, old, new)
            becomes = ast.unparse(new if old is statement else statement).splitlines()[0]
            code = compiled(function)
            swap(function, new, old)
            if becomes != line:  # one more than a large number may be the same number
                text = f"{module}.{function.name}", line, becomes
                met[text] = met.get(text, 0) + 1
                yield name_of(*text, met[text]), code


def function_of(name: str) -> Any:
    """Return a function of the core, without its decorators."""
    module, function = name.split(".")
    return inspect.unwrap(getattr(importlib.import_module(f"catch_arena.core.{module}"), function))


def run_all() -> list[tuple[float, int, set[str]]]:
    """Run all tests on the core as it is, and return `calls`."""
    called: set[str] = set()
    for name in {mutant.split(maxsplit=1)[0] for mutant in codes}:
        function = function_of(name)
        definition: Any = ast.parse(inspect.getsource(function)).body[0]
        definition.body.insert(0, ast.parse(f"_called.add({name!r})").body[0])
        function.__code__, function.__globals__["_called"] = compiled(definition), called
    found = []
    for place, item in enumerate(tests):
        called.clear()
        begun = time.process_time()
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)  # no fixture is kept for the next test
        if item.session.testsfailed:
            raise RuntimeError(f"the core as it is fails {item.nodeid}; mend that first")
        found.append((time.process_time() - begun, place, set(called)))
    return sorted(found)


def is_noticed(mutant: str) -> bool:
    """Make a mutant, and return whether a test notices it; tests that take less time run first."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    signal.signal(signal.SIGVTALRM, signal.default_int_handler)  # KeyboardInterrupt: no test catches it
    function = mutant.split(maxsplit=1)[0]
    function_of(function).__code__ = codes[mutant]
    for seconds, item in [(seconds, tests[place]) for seconds, place, called in calls if function in called]:
        signal.setitimer(signal.ITIMER_VIRTUAL, 5 + 5 * seconds)  # of processor time, since some mutants never end
        try:
            item.config.hook.pytest_runtest_protocol(item=item, nextitem=None)
        except KeyboardInterrupt:
            return True
        if item.session.testsfailed:
            return True
    return False


def pytest_runtestloop(session: Any) -> bool:
    """Run all tests once, then on each mutant those that call its function; pytest calls this as a plugin's hook."""
    fork = multiprocessing.get_context("fork")  # each process has the variables of this module
    tests.extend(session.items)
    with fork.Pool(1) as pool:
        calls.extend(pool.apply(run_all))
    with progress_bar("mutants", len(codes)) as show, fork.Pool(maxtasksperchild=1) as pool:
        for done, (mutant, noticed) in enumerate(zip(codes, pool.imap(is_noticed, codes), strict=True)):
            show(done + 1, len(codes))
            if not noticed:
                print(f"no test notices: {mutant}", flush=True)
                session.testsfailed += 1
    print(f"{len(codes)} mutants: {session.testsfailed} not noticed")
    return True


def main() -> None:
    """Try the mutants; exit with 1 if one that is not listed survives, or if the list is out of date."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--only", default="", metavar="TEXT", help='mutants whose name or text contains this ("prey.")')
    only = parser.parse_args().only
    os.chdir(ROOT)
    os.environ |= {"NUMBA_DISABLE_JIT": "1", "OPENBLAS_NUM_THREADS": "1"}
    import pytest  # after the settings that its plugins and the core read when they load

    made = (one for module in SETTINGS["modules"] for one in mutants_of(module))
    codes.update((name, code) for name, code in made if only in name)
    for one in SETTINGS["equivalent"]:
        for becomes in one["becomes"]:
            name = name_of(one["function"], one["line"], becomes, one.get("nth", 1))
            if only in name and codes.pop(name, None) is None:
                sys.exit(f"listed, but there is no such mutant: {name}")
    flags = ("-x", "-q", "--capture=no", "-p", "no:cacheprovider", "--assert=plain", "-k", SETTINGS["without"])
    sys.exit(pytest.main([*flags, *SETTINGS["tests"]], [sys.modules[__name__]]))


if __name__ == "__main__":
    main()
