"""Compilation of the core as one piece, with Numba.

Numba optimises each function and makes machine code of it, then links it into its callers and does so again there.
Here the parts are only translated, and the whole is linked, optimised and emitted once. Branches that are never taken,
since a setting is 0, are left out. Arrays take less code than Numba's own (`addresses`). The calculations reach
LLVM as they do in Numba's own way: no bit depends on this file (R10.1), only the time to compile.

Everything that is not public in Numba, and may change, is in this file and in `cache`. If this Numba lacks something,
the import fails, and `modes` selects Numba's own way.
"""

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
import numba.core.cpu
import numba.core.ir
import numba.core.ir_utils
import numba.core.typed_passes
import numba.core.untyped_passes
from llvmlite import binding

# typed in a few places, but not in those used here
_dynfunc: Any = numba._dynfunc  # noqa: SLF001
codegen: Any = numba.core.codegen
compiler: Any = numba.core.compiler
cpu: Any = numba.core.cpu
ir: Any = numba.core.ir
ir_utils: Any = numba.core.ir_utils
typed_passes: Any = numba.core.typed_passes
untyped_passes: Any = numba.core.untyped_passes
_machinery: Any = numba.core.compiler_machinery

HAS_AVX512VL: Final = binding.get_host_cpu_features().get("avx512vl", False)
"""True if this processor has AVX-512VL: see `vectors.PLAYED`."""

FLAGS: Final = {"_nrt": False}
"""Flag by which nothing is counted and freed: the core makes no arrays, and code for one arena runs a third faster."""
_ENDING: Final = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
_Library: Any = codegen.JITCodeLibrary
_NEEDED: Final = (
    _Library.add_linking_library,
    _Library.enable_object_caching,
    _Library.get_function,
    _Library.get_pointer_to_function,
    _Library._ensure_finalized,  # noqa: SLF001
    _Library._finalize_final_module,  # noqa: SLF001
    _Library._get_module_for_linking,  # noqa: SLF001
    _Library._raise_if_finalized,  # noqa: SLF001
    codegen.CPUCodegen._check_llvm_bugs,  # noqa: SLF001
    codegen.CPUCodegen._module_pass_manager,  # noqa: SLF001
    numba.core.caching.Cache._load_overload,  # noqa: SLF001
    compiler.Flags.no_compile,
    compiler.DefaultPassBuilder.define_untyped_pipeline,
    compiler.DefaultPassBuilder.define_typed_pipeline,
    compiler.DefaultPassBuilder.define_nopython_lowering_pipeline,
    (ir.Arg, ir.Assign, ir.Const, ir.Expr),
    (ir_utils.get_definition, ir_utils.guard),
    cpu.CPUContext.insert_user_function,
    cpu.CPUTargetOptions._nrt,  # noqa: SLF001
    untyped_passes.RewriteSemanticConstants,
    _dynfunc.make_function,
)
"""Names that are used only while something is compiled, so that importing this module fails if one is missing."""


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Hold back the signals that end a program, and handle them after this block. LLVM calls Python when it has made
    the machine code; an exception there would be lost, and so would the code. No signal would be handled earlier
    anyway.
    """
    delayed: list[tuple[Any, tuple[Any, ...]]] = []
    held = []
    if threading.current_thread() is threading.main_thread():  # only the main thread handles signals
        held = [(number, handler) for number in _ENDING if callable(handler := signal.getsignal(number))]
    try:
        for number, handler in held:
            signal.signal(number, lambda *arguments, handler=handler: delayed.append((handler, arguments)))
        yield
    finally:
        for number, handler in held:
            signal.signal(number, handler)
        for handler, arguments in delayed:
            handler(*arguments)


class _Translated(_Library):  # type: ignore[misc]
    """Library of functions as LLVM's code, not optimised one by one."""

    def add_llvm_module(self, module: Any) -> None:
        """Link in a module without optimising it."""
        try:
            self._final_module.link_in(module)
        except BaseException:  # Ctrl-C: LLVM has the module already, and llvmlite would free it once more
            module.detach()
            raise


class _Part(_Translated):
    """Library of a function that only the core's functions call: never optimised alone, never emitted."""

    def finalize(self) -> None:
        """Mark the part as final; `Whole.finalize` does the work."""
        self._raise_if_finalized()
        self._finalized = True


class Whole(_Translated):
    """Library of a function that Python calls, with all that it calls."""

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
        # once, although Numba does so three times; and without the search for loops that could be vectors
        manager, builder = self._codegen._module_pass_manager(opt=2, loop_vectorize=False, slp_vectorize=False)  # noqa: SLF001
        manager.run(self._final_module, builder)
        self._final_module.verify()
        with interrupts_held():
            self._finalize_final_module()


@_machinery.register_pass(mutates_CFG=False, analysis_only=False)
class _Substitute(_machinery.FunctionPass):  # type: ignore[misc]
    """Replace fields of a parameter by zeros if its type has them in `zero`. Numba then leaves out the branches for
    other values, before it compiles the functions that are called there.
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
        # key by which Numba finds the function: an object without an address, as for every function without a wrapper
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
"""Passes that the core does not need. It has no closures, contexts and exceptions, no inlining before translation, no
loops over literals and no arithmetic with whole arrays. It has no reference counts either, for which Numba notes the
last use of each variable.
"""


@_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class _LowerOutlined(_LowerPart):
    """Pass that makes one copy of the code, small and not fast."""

    _name = "catch_arena_lower_outlined"

    def run_pass(self, state: Any) -> bool:
        super().run_pass(state)
        function = state.library.get_function(state["cr"].fndesc.llvm_func_name)
        for attribute in ("noinline", "minsize", "optsize"):
            function.add_function_attribute(attribute)
        return True


class _Compiler(compiler.CompilerBase):  # type: ignore[misc]
    lowering: Any
    """Pass that takes the place of the last one."""

    def define_pipelines(self) -> list[Any]:
        """Return Numba's passes without those that the core does not need, with `_Substitute` and our last pass."""
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
    """Compiler of outlined phases."""

    lowering = _LowerOutlined


class PartCompiler(_Compiler):
    """Compiler of rules and phases."""

    lowering = _LowerPart


class WholeCompiler(_Compiler):
    """Compiler of functions that Python calls."""

    lowering = _LowerWhole
