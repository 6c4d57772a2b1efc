"""Numba compiles the core as one piece.

Numba optimises each function and makes machine code of it, then links it into its callers and does so again there.
Here the parts are only translated; the whole is linked, optimised and emitted once; branches that are never taken,
since a setting is 0, are left out; and what Numba says of arrays in much code is said in little (`addresses`). What is
calculated reaches LLVM as it is in Numba's own way: no bit depends on this file (R10.1), only the time to compile.

What is not public in Numba, and may change, stands in this file and in `cache`. `USABLE` is false if this Numba lacks
what is needed here, and then all is compiled in Numba's own way.
"""

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final

import numba._dynfunc
import numba.core.caching
import numba.core.codegen
import numba.core.compiler
import numba.core.compiler_machinery
import numba.core.config
import numba.core.cpu
import numba.core.ir
import numba.core.ir_utils
import numba.core.typed_passes
import numba.core.types
import numba.core.typing.templates
import numba.core.untyped_passes

# typed here and there, and not where it matters
_dynfunc: Any = numba._dynfunc  # noqa: SLF001
codegen: Any = numba.core.codegen
compiler: Any = numba.core.compiler
cpu: Any = numba.core.cpu
ir: Any = numba.core.ir
ir_utils: Any = numba.core.ir_utils
typed_passes: Any = numba.core.typed_passes
types: Any = numba.core.types
untyped_passes: Any = numba.core.untyped_passes
_machinery: Any = numba.core.compiler_machinery
AttributeTemplate: Any = numba.core.typing.templates.AttributeTemplate

_ENDING: Final = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_Library: Any = codegen.JITCodeLibrary
_NEEDED: Final[dict[Any, str]] = {
    _Library: "add_linking_library add_llvm_module enable_object_caching finalize get_function get_pointer_to_function "
    "_ensure_finalized _finalize_final_module _get_module_for_linking _raise_if_finalized",
    numba.core.caching.Cache: "_load_overload",
    codegen.CPUCodegen: "_check_llvm_bugs _module_pass_manager",
    compiler.CompilerBase: "define_pipelines",
    compiler.DefaultPassBuilder: "define_nopython_lowering_pipeline define_typed_pipeline define_untyped_pipeline",
    compiler.Flags: "no_compile",
    ir: "Arg Assign Const Expr",
    ir_utils: "get_definition guard",
    cpu.CPUContext: "insert_user_function",
    typed_passes: "IRLegalization InlineOverloads NativeLowering NopythonRewrites",
    untyped_passes: "FindLiterallyCalls InlineClosureLikes InlineInlinables LiteralPropagationSubPipelinePass "
    "LiteralUnroll MakeFunctionToJitFunction RewriteDynamicRaises RewriteSemanticConstants WithLifting",
    _dynfunc: "make_function",
}
USABLE: Final = os.environ.get("CATCH_ARENA_COMPILER") != "numba" and all(
    hasattr(owner, name) for owner, names in _NEEDED.items() for name in names.split()
)
"""False if this Numba lacks what is needed here, or CATCH_ARENA_COMPILER=numba: then all is compiled in its own way."""
numba_settings: Any = numba.core.config
"""Numba's settings; the module fills itself, so that type checkers see none of them."""
INTERPRETED: Final = bool(numba_settings.DISABLE_JIT)
"""NUMBA_DISABLE_JIT=1: the core runs as plain Python, for debuggers, coverage and doubters."""
CHECKED: Final = bool(numba_settings.BOUNDSCHECK)
"""NUMBA_BOUNDSCHECK=1: compiled code tests each index."""


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Signals that end a program are handled behind this block. LLVM calls back into Python as soon as it has made the
    machine code; what is raised there is lost, and so is the code. Until then no signal would be handled anyway.
    """
    heard: list[tuple[Any, tuple[Any, ...]]] = []
    held = []
    if threading.current_thread() is threading.main_thread():  # no other one handles signals
        held = [(number, handler) for number in _ENDING if callable(handler := signal.getsignal(number))]
    try:
        for number, handler in held:
            signal.signal(number, lambda *arguments, handler=handler: heard.append((handler, arguments)))
        yield
    finally:
        for number, handler in held:
            signal.signal(number, handler)
        for handler, arguments in heard:
            handler(*arguments)


class _Translated(_Library):  # type: ignore[misc]
    """Functions as LLVM's code, not optimised one by one."""

    def add_llvm_module(self, module: Any) -> None:
        """As it stands."""
        try:
            self._final_module.link_in(module)
        except BaseException:  # Ctrl-C: LLVM has the module already, and llvmlite would free it once more
            module.detach()
            raise


class _Part(_Translated):
    """A function that only others of ours call: never optimised alone, never emitted."""

    def finalize(self) -> None:
        """There is nothing to be done: see `Whole.finalize`."""
        self._raise_if_finalized()
        self._finalized = True


class Whole(_Translated):
    """What Python calls, and all that it calls."""

    def finalize(self) -> None:
        """Link all parts, each once; optimise and emit them."""
        self._raise_if_finalized()
        self._codegen._check_llvm_bugs()  # noqa: SLF001
        linked: set[Any] = set()
        waiting = list(self._linking_libraries)
        while waiting:
            library = waiting.pop()
            if library in linked:
                continue
            linked.add(library)
            if isinstance(library, _Part):
                waiting += library._linking_libraries  # noqa: SLF001
            self._reload_init.update(library._reload_init)  # noqa: SLF001
            self.add_llvm_module(library._get_module_for_linking().clone())  # noqa: SLF001
        self._final_module.data_layout = self._codegen._data_layout  # noqa: SLF001
        # once, where Numba does so three times; and without the search for loops that could be vectors
        manager, builder = self._codegen._module_pass_manager(opt=2, loop_vectorize=False, slp_vectorize=False)  # noqa: SLF001
        manager.run(self._final_module, builder)
        self._final_module.verify()
        with interrupts_held():
            self._finalize_final_module()


@_machinery.register_pass(mutates_CFG=False, analysis_only=False)
class _Substitute(_machinery.FunctionPass):  # type: ignore[misc]
    """Fields of a parameter that its type has in `zero` become zeros: Numba then leaves out the branches that would be
    taken if they were not, before it looks at what is called there.
    """

    _name = "catch_arena_substitute"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        function = state.func_ir
        for block in function.blocks.values():
            for assignment in block.find_insts(ir.Assign):
                found = self._in_place_of(assignment.value, function, state.args)
                if found is not None:
                    assignment.value = found
                    function._definitions[assignment.target.name] = [found]  # noqa: SLF001
        return True

    def _in_place_of(self, value: Any, function: Any, parameters: Any) -> Any:
        if isinstance(value, ir.Expr) and value.op == "getattr":
            source = ir_utils.guard(ir_utils.get_definition, function, value.value)
            zero = getattr(parameters[source.index], "zero", {}) if isinstance(source, ir.Arg) else {}
            return ir.Const(zero[value.attr], value.loc) if value.attr in zero else None
        return None


@_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class _LowerPart(typed_passes.NativeLowering):  # type: ignore[misc]
    _name = "catch_arena_lower_part"

    def run_pass(self, state: Any) -> bool:
        state.library = _Part(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        lowered = state["cr"]
        name, module = lowered.fndesc.qualname, lowered.fndesc.lookup_module()
        # what Numba finds the function by: an object without an address, as for every function without a wrapper
        key = _dynfunc.make_function(module, name.rpartition(".")[2], "", 0, lowered.env, (state.library,))
        state.targetctx.insert_user_function(key, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=key)
        return True


@_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class _LowerWhole(typed_passes.NativeLowering):  # type: ignore[misc]
    _name = "catch_arena_lower_whole"

    def run_pass(self, state: Any) -> bool:
        state.library = Whole(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super().run_pass(state)  # type: ignore[no-any-return]


_SKIPPED: Final = {
    typed_passes.IRLegalization,
    typed_passes.InlineOverloads,
    typed_passes.NopythonRewrites,
    untyped_passes.FindLiterallyCalls,
    untyped_passes.InlineClosureLikes,
    untyped_passes.InlineInlinables,
    untyped_passes.LiteralPropagationSubPipelinePass,
    untyped_passes.LiteralUnroll,
    untyped_passes.MakeFunctionToJitFunction,
    untyped_passes.RewriteDynamicRaises,
    untyped_passes.WithLifting,
}
"""The core has no closures, contexts and exceptions, nothing that is inlined before it is translated, no loops over
literals and no arithmetic with whole arrays; and nothing that is counted and freed, for which Numba notes where each
variable is used last.
"""


@_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class _LowerOutlined(_LowerPart):
    """One copy of the code, made small and not fast."""

    _name = "catch_arena_lower_outlined"

    def run_pass(self, state: Any) -> bool:
        super().run_pass(state)
        function = state.library.get_function(state["cr"].fndesc.llvm_func_name)
        for attribute in ("noinline", "minsize", "optsize"):
            function.add_function_attribute(attribute)
        return True


class _Compiler(compiler.CompilerBase):  # type: ignore[misc]
    lowering: Any
    """The last of the passes."""

    def define_pipelines(self) -> list[Any]:
        """Numba's passes, but for those that the core does not need, with one more, and ours in place of the last."""
        builder = compiler.DefaultPassBuilder
        manager = _machinery.PassManager("catch_arena")
        for part in (
            builder.define_untyped_pipeline(self.state),
            builder.define_typed_pipeline(self.state),
            builder.define_nopython_lowering_pipeline(self.state),
        ):
            for step, description in part.passes:
                if step is untyped_passes.RewriteSemanticConstants:
                    manager.add_pass(_Substitute, "what we have in place of something")
                if step is typed_passes.NativeLowering:
                    manager.add_pass(self.lowering, description)
                elif step not in _SKIPPED:
                    manager.add_pass(step, description)
        manager.finalize()
        return [manager]


class OutlinedCompiler(_Compiler):
    """For outlined phases."""

    lowering = _LowerOutlined


class PartCompiler(_Compiler):
    """For rules and phases."""

    lowering = _LowerPart


class WholeCompiler(_Compiler):
    """For what Python calls."""

    lowering = _LowerWhole
