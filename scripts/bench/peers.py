"""Similar environments from other projects (peers), each stepped as its authors recommend.

Every peer gets fixed actions, so that no policy is measured, and begins a new episode when one ends.
"""

import ctypes
import os
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from subject import Row, Subject

HEADER = Path("pufferlib", "ocean", "target", "target.h")
"""Header of PufferLib's environment `target`, in its source package."""
_FLAGS = ("-O3", "-march=native", "-fwrapv", "-shared", "-fPIC")
"""Compiler flags for the processor of this machine, as for our own code."""
_UNDRAWN = ("-fvisibility=hidden", "-ffunction-sections", "-Wl,--gc-sections")
"""Compiler flags that leave out the functions that draw, so that only raylib's header is needed."""
_FLOATS = 16
"""Numbers in an agent's observation in each of the simple_tags."""


def rows(pufferlib: Path | None) -> dict[str, Row]:
    """Return all peers by name; `pufferlib` is PufferLib's unpacked source package."""
    small, large, scan = 1024, 16384, 16
    made: dict[str, Callable[[], Subject]] = {
        "mpe2 simple_tag_v3": mpe2_simple_tag,
        "VMAS simple_tag": partial(vmas_simple_tag, 1),
        "VMAS simple_tag, 1,024 at once": partial(vmas_simple_tag, small),
        "VMAS simple_tag, 16,384 at once": partial(vmas_simple_tag, large),
        "JaxMARL simple_tag, 1,024 at once": partial(jaxmarl_simple_tag, small, scan),
        "JaxMARL simple_tag, 16,384 at once": partial(jaxmarl_simple_tag, large, scan),
        "PufferLib target, 14 goals, 1,024 at once": partial(pufferlib_target, pufferlib, small, 14, scan),
        "PufferLib target, 30 goals, 1,024 at once": partial(pufferlib_target, pufferlib, small, 30, scan),
    }
    return {name: Row("peers", "ns per agent-step", make) for name, make in made.items()}


def mpe2_simple_tag() -> Subject:
    """Make the original particle world: 3 pursuers and 1 evader."""
    from mpe2 import simple_tag_v3

    env = simple_tag_v3.parallel_env(max_cycles=600)
    env.reset(seed=1)
    actions = dict.fromkeys(env.agents, 1)

    def step() -> None:
        env.step(actions)
        if not env.agents:
            env.reset()

    return Subject(step, len(actions), floats=_FLOATS)


def vmas_simple_tag(envs: int) -> Subject:
    """Make simple_tag over PyTorch tensors; it has no end of its own, so it never resets."""
    import torch
    import vmas

    torch.set_num_threads(1)
    env = vmas.make_env("simple_tag", num_envs=envs, device="cpu", continuous_actions=False, seed=1)
    env.reset()
    actions = [torch.ones(envs, 1, dtype=torch.long) for _ in env.agents]

    def step() -> None:
        with torch.no_grad():
            env.step(actions)

    return Subject(step, 4, envs, _FLOATS)


def jaxmarl_simple_tag(envs: int, steps: int) -> Subject:
    """Make simple_tag over JAX: vmap over environments, scan over steps, all under jit, which is its fastest way."""
    import jax
    import jaxmarl

    env = jaxmarl.make("MPE_simple_tag_v3")
    actions = dict.fromkeys(env.agents, jax.numpy.ones(envs, dtype=jax.numpy.int32))
    keys = jax.random.split(jax.random.PRNGKey(2), steps)

    def one(carry: tuple, key: object) -> tuple:
        observations, state, rewards, *_ = jax.vmap(env.step)(jax.random.split(key, envs), carry[1], actions)
        return (observations, state, rewards), None

    _, state = jax.vmap(env.reset)(jax.random.split(jax.random.PRNGKey(1), envs))
    carry, _ = one((None, state, None), jax.random.PRNGKey(2))
    run = jax.jit(lambda carry: jax.lax.scan(one, carry, keys)[0])  # carries observations, so that none is dropped

    def step() -> None:
        nonlocal carry
        carry = jax.block_until_ready(run(carry))

    return Subject(step, 4, envs, _FLOATS, steps_per_call=steps)


def pufferlib_target(source: Path | None, envs: int, goals: int, steps: int) -> Subject:
    """Make puffers that eat stars, in C and without Python; 30 stars are as many floats as our standard arena's."""
    if source is None:
        raise ValueError("PufferLib's source package is missing; give it with --pufferlib")
    library = compiled(source)
    made = library.make_batch(envs, 4, goals)
    if not made:
        raise MemoryError
    return Subject(lambda: library.play(made, steps), 4, envs, 2 * (4 + goals) + 4, steps_per_call=steps)


def compiled(source: Path) -> ctypes.CDLL:
    """Compile puffer.c with the header of PufferLib's source package, and load it.

    Raises:
        RuntimeError: the compiler failed; the message is its first error.
        FileNotFoundError: there is no compiler.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "puffer.so")
        headers = [f"-I{one}" for one in (source / HEADER.parent, *sorted(source.glob("raylib-*/include")))]
        driver = Path(__file__).with_name("puffer.c")
        command = [os.environ.get("CC", "cc"), *_FLAGS, *_UNDRAWN, *headers, driver, "-lm", "-o", path]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            errors = (line for line in done.stderr.splitlines() if "error" in line)
            raise RuntimeError(next(errors, done.stderr).replace(f"{source}{os.sep}", ""))
        library = ctypes.CDLL(str(path))
    library.make_batch.restype = ctypes.c_void_p
    library.play.argtypes = (ctypes.c_void_p, ctypes.c_int)
    return library
