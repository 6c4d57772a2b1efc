"""`tick.run` as object files, for processors other than this one, beside the manifest that catch_arena.engine.prebuilt
reads. A program of its own: `PYTHONHASHSEED=0 python object_files.py FOLDER`, with the sources first on Python's path.

Numba translates each variant once, and LLVM optimises and emits that for each level of x86-64, with the passes and
options that catch_arena.core.compiler takes. The same versions of Python, Numba and llvmlite make the same bytes of the
same sources.
"""

import hashlib
import json
import platform
import struct
import sys
import sysconfig
from pathlib import Path
from typing import Any

import llvmlite
import numba
from llvmlite import binding as llvm
from llvmlite import ir
from numba.core import types
from numba.core.codegen import create_pass_builder

from catch_arena.core import tick
from catch_arena.core.compiler import USABLE, Whole, quick_typing
from catch_arena.core.jit import phase, sources_digest
from catch_arena.core.state import ALL_OPTIONS, NO_OPTIONS, Options
from catch_arena.core.vectors import HALF, SINGLE, WIDE, Width
from catch_arena.engine.prebuilt import ENTRY, MANIFEST

V2 = ["cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"]
V3 = [*V2, "avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"]
V4 = [*V3, "avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"]
LEVELS = {"x86-64-v4": (V4, WIDE), "x86-64-v3": (V3, HALF), "x86-64-v2": (V2, HALF)}
"""The best first: of each what it adds to x86-64, in LLVM's words, and how many lanes of a batch play at a time there
(see `vectors.PLAYED`).
"""
RESOLVED = {"memcpy", "memmove", "memset"}
"""What may be left to be found where the code is loaded: the C library's."""
ARGUMENTS = (
    types.Array(types.uint8, 1, "C"),
    types.int64,
    types.int64,
    types.int64,
    types.Array(types.uint64, 2, "C"),
    types.boolean,
    types.Array(types.int64, 2, "C"),
    types.Array(types.float32, 3, "C"),
    types.Array(types.int64, 2, "C"),
)
"""Of `tick.run`, from `memory` on: see `prebuilt.PrebuiltRun`."""
INT64 = ir.IntType(64)


def translated(width: Width, view_width: Width, options: Options) -> Any:
    """A variant, with all that it calls and our entry, as LLVM's module; for any processor yet."""
    part: Any = phase(tick.run.py_func)  # type: ignore[attr-defined]
    with quick_typing():
        part.compile((*map(numba.typeof, (width, view_width, options)), *ARGUMENTS))
    compiled = part.overloads[part.signatures[0]]
    whole = Whole(compiled.library.codegen, ENTRY)
    whole.add_ir_module(entry_of(compiled))
    whole.add_linking_library(compiled.library)
    return whole.link()


def entry_of(compiled: Any) -> Any:
    """A function of plain C that takes the address of what `prebuilt.PrebuiltRun` packs, and calls the compiled one."""
    context = compiled.target_context
    module = compiled.library.create_ir_module(ENTRY)
    function = ir.Function(module, ir.FunctionType(ir.IntType(32), [INT64.as_pointer()]), ENTRY)
    builder = ir.IRBuilder(function.append_basic_block())
    read = 0

    def word() -> Any:
        nonlocal read
        read += 1
        return builder.load(builder.gep(function.args[0], [INT64(read - 1)]))

    arguments = []
    for kind in compiled.fndesc.argtypes:
        if isinstance(kind, types.Array):
            array = context.make_array(kind)(context, builder)
            data = builder.inttoptr(word(), array.data.type)
            shape = [word() for _ in range(kind.ndim)]
            strides = [INT64(kind.dtype.bitwidth // 8)]
            for extent in shape[:0:-1]:
                strides.insert(0, builder.mul(strides[0], extent))
            context.populate_array(array, data=data, shape=shape, strides=strides, itemsize=strides[-1], meminfo=None)
            arguments.append(array._getvalue())  # noqa: SLF001 - Numba's own extensions call it
        elif isinstance(kind, types.BaseTuple):  # a width or the options: only how long they are matters
            arguments.append(ir.Constant(context.get_value_type(kind), None))
        else:
            arguments.append(word() if kind == types.int64 else builder.trunc(word(), context.get_value_type(kind)))
    status, _ = context.call_conv.call_function(
        builder,
        context.declare_function(module, compiled.fndesc),
        compiled.fndesc.restype,
        compiled.fndesc.argtypes,
        arguments,
    )
    builder.ret(status.code)
    return module


def emitted(module: Any, level: str) -> bytes:
    """An object file for that level."""
    module = module.clone()
    machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine(
        cpu=level, opt=3, reloc="static", codemodel="jitdefault", jit=True
    )
    module.data_layout = str(machine.target_data)
    for one in [*module.functions, *module.global_variables]:
        if not one.is_declaration and one.name != ENTRY:  # no names, which tell of this process
            one.linkage = "private"
    builder = create_pass_builder(machine, opt=2, loop_vectorize=False, slp_vectorize=False)
    builder.getModulePassManager().run(module, builder)
    module.verify()
    return bytes(machine.emit_object(module))


def undefined_symbols(content: bytes) -> list[str]:
    """What an object file (ELF of 64 bits) leaves to be found where it is loaded."""
    (sections_at,), (size, count) = struct.unpack_from("<Q", content, 40), struct.unpack_from("<2H", content, 58)
    # of each section: its name, its type, flags, address, where it begins, its size, and which other belongs to it
    sections = [struct.unpack_from("<2I4QI", content, sections_at + index * size) for index in range(count)]
    found = []
    for _, kind, _, _, begin, length, names in sections:
        if kind != 2:  # SHT_SYMTAB
            continue
        for at in range(begin + 24, begin + length, 24):  # the first stands for none
            name, _, _, section = struct.unpack_from("<I2BH", content, at)
            if section == 0:
                start = sections[names][4] + name
                found.append(content[start : content.index(b"\0", start)].decode())
    return sorted(found)


def require_portable(content: bytes, name: str) -> None:
    """End where another machine could not load the file, or where it tells of this one."""
    if unknown := set(undefined_symbols(content)) - RESOLVED:
        sys.exit(f"{name} must not need {sorted(unknown)}")
    if b".py\0" in content or str(Path(numba.__file__).parent).encode() in content:
        sys.exit(f"{name} must not hold the paths of this machine: something in the core raises an exception")


def main() -> None:
    """Write the files into the folder that is named."""
    folder = Path(sys.argv[1])
    if not USABLE:
        sys.exit("this Numba has not what catch_arena.core.compiler needs")
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    folder.mkdir(parents=True, exist_ok=True)
    code = []
    for width, view_width in ((SINGLE, SINGLE), (HALF, WIDE), (WIDE, WIDE)):
        for options in (NO_OPTIONS, ALL_OPTIONS):
            module = translated(width, view_width, options)
            for level, (features, lanes) in LEVELS.items():
                if width not in (SINGLE, lanes):
                    continue
                content = emitted(module, level)
                name = f"{level}-{len(width)}-{'all' if options else 'common'}.o"
                require_portable(content, name)
                (folder / name).write_bytes(content)
                print(f"{name}: {len(content)} bytes", flush=True)
                code.append(
                    {
                        "file": name,
                        "features": features,
                        "lanes": len(width),
                        "options": bool(options),
                        "symbols": undefined_symbols(content),
                        "blake2b": hashlib.blake2b(content).hexdigest(),
                    }
                )
    manifest = {
        "platform": sysconfig.get_platform(),
        "sources": sources_digest(),
        "made_with": {
            "python": platform.python_version(),
            "numba": numba.__version__,
            "llvmlite": llvmlite.__version__,
        },
        "code": code,
    }
    (folder / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
