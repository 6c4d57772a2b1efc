"""Environments of the same kind from other projects, each stepped in the way that its authors recommend.

Every peer gets fixed actions, so that nobody's policy is measured, and begins a new episode where one ends. What is not
installed, or fails, is named as skipped.
"""

import contextlib
import io
from collections.abc import Callable, Iterator
from pathlib import Path

from measure import Subject, Work
from puffer import Driver
from wanted import BESIDE_PUFFERLIB

PEERS = "peers"
MPE2 = "mpe2 simple_tag_v3"
PUFFERLIB = "PufferLib target"
_EPISODE = 600


def _parallel(name: str, env: object, floats: int, ticks: str) -> Subject:
    """Any PettingZoo parallel env whose agents all take the same fixed action."""
    env.reset(seed=1)
    actions = dict.fromkeys(env.agents, 1)

    def step() -> None:
        env.step(actions)
        if not env.agents:
            env.reset()

    return Subject(PEERS, name, step, len(actions), Work(floats, ticks, arbiter=False))


def mpe2_simple_tag(sizes: "Sizes") -> Iterator[Subject]:
    """3 pursuers and 1 evader; the original particle world."""
    del sizes
    from mpe2 import simple_tag_v3

    yield _parallel(MPE2, simple_tag_v3.parallel_env(max_cycles=_EPISODE), 16, "1")


def sisl_pursuit(sizes: "Sizes") -> Iterator[Subject]:
    """8 pursuers and 30 evaders on a grid."""
    del sizes
    from pettingzoo.sisl import pursuit_v5

    env = pursuit_v5.parallel_env(max_cycles=_EPISODE)
    yield _parallel("PettingZoo sisl pursuit_v5", env, 7 * 7 * 3, "none: a grid")


def magent2_pursuit(sizes: "Sizes") -> Iterator[Subject]:
    """25 predators and 50 prey on a grid, in C++."""
    del sizes
    from magent2.environments import adversarial_pursuit_v4

    env = adversarial_pursuit_v4.parallel_env(max_cycles=_EPISODE)
    yield _parallel("MAgent2 adversarial_pursuit_v4", env, 10 * 10 * 5, "none: a grid")


def vmas_simple_tag(sizes: "Sizes") -> Iterator[Subject]:
    """simple_tag over PyTorch tensors; it has no end of its own, so that it never resets."""
    import torch
    import vmas

    torch.set_num_threads(1)
    for envs in sizes.vmas:
        env = vmas.make_env("simple_tag", num_envs=envs, device="cpu", continuous_actions=False, seed=1)
        env.reset()
        actions = [torch.ones(envs, 1, dtype=torch.long) for _ in env.agents]

        def step(env: object = env, actions: object = actions) -> None:
            with torch.no_grad():
                env.step(actions)

        yield Subject(PEERS, "VMAS simple_tag", step, 4, Work(16, "1", arbiter=False), envs=envs)


def jaxmarl_simple_tag(sizes: "Sizes") -> Iterator[Subject]:
    """simple_tag over JAX: vmap over environments, scan over steps, all under jit, which is its fastest way."""
    import jax
    import jaxmarl

    env = jaxmarl.make("MPE_simple_tag_v3")
    for envs in sizes.jax:
        actions = dict.fromkeys(env.agents, jax.numpy.ones(envs, dtype=jax.numpy.int32))

        def one(carry: tuple, key: object, envs: int = envs, actions: object = actions) -> tuple:
            observations, state, rewards, *_ = jax.vmap(env.step)(jax.random.split(key, envs), carry[1], actions)
            return (observations, state, rewards), None

        _, state = jax.vmap(env.reset)(jax.random.split(jax.random.PRNGKey(1), envs))
        carry, _ = one((None, state, None), jax.random.PRNGKey(2))
        step = _scanned(one, carry, sizes.scan)
        work = Work(16, "1", arbiter=False)
        yield Subject(PEERS, "JaxMARL simple_tag", step, 4, work, envs=envs, steps_per_call=sizes.scan)


def jumanji_search_and_rescue(sizes: "Sizes") -> Iterator[Subject]:
    """2 searchers look for targets in a continuous square, over JAX; each sees 128 rays in 3 channels."""
    import jax
    import jumanji

    env = jumanji.make("SearchAndRescue-v0")
    envs = sizes.jax[0]
    actions = jax.numpy.zeros((envs, *env.action_spec.shape))

    def one(carry: tuple, _: object) -> tuple:
        return jax.vmap(env.step)(carry[0], actions), None

    step = _scanned(one, jax.vmap(env.reset)(jax.random.split(jax.random.PRNGKey(1), envs)), sizes.scan)
    agents = env.action_spec.shape[0]
    work = Work(3 * 128, "1", arbiter=False)
    yield Subject(PEERS, "Jumanji SearchAndRescue-v0", step, agents, work, envs=envs, steps_per_call=sizes.scan)


def _scanned(one: Callable, carry: object, steps: int) -> Callable[[], None]:
    """That many steps in one compiled call. The last observations are carried along, so that none is optimised away."""
    import jax

    keys = jax.random.split(jax.random.PRNGKey(2), steps)
    run = jax.jit(lambda carry: jax.lax.scan(one, carry, keys)[0])

    def step() -> None:
        nonlocal carry
        carry = jax.block_until_ready(run(carry))

    return step


def pufferlib_target(sizes: "Sizes") -> Iterator[Subject]:
    """Puffers eat stars, in C and without Python; with 30 stars it writes as many floats as our standard arena."""
    if sizes.pufferlib is None:
        raise ValueError("its source package is not named: --pufferlib")
    driver, envs = Driver(sizes.pufferlib), sizes.jax[0]
    for goals in BESIDE_PUFFERLIB:
        step = driver.batch(envs, 4, goals, sizes.scan)
        work = Work(2 * (4 + goals) + 4, "1", arbiter=False)
        name = f"{PUFFERLIB}, {goals} goals"
        yield Subject(PEERS, name, step, 4, work, envs=envs, steps_per_call=sizes.scan)


class Sizes:
    """How large the peers' batches are, and where the source package of one lies."""

    def __init__(self, *, quick: bool, pufferlib: Path | None) -> None:
        self.pufferlib = pufferlib
        self.vmas = (1, 4) if quick else (1, 1024, 16384)
        self.jax = (4,) if quick else (1024, 16384)
        self.scan = 2 if quick else 16


_MAKERS = {
    MPE2: mpe2_simple_tag,
    "PettingZoo sisl pursuit_v5": sisl_pursuit,
    "MAgent2 adversarial_pursuit_v4": magent2_pursuit,
    "VMAS simple_tag": vmas_simple_tag,
    "JaxMARL simple_tag": jaxmarl_simple_tag,
    "Jumanji SearchAndRescue-v0": jumanji_search_and_rescue,
    PUFFERLIB: pufferlib_target,
}


def peers(*, quick: bool, pufferlib: Path | None) -> tuple[list[Subject], dict[str, str]]:
    """All peers that run here, and why the others do not."""
    subjects, skipped = [], {}
    sizes = Sizes(quick=quick, pufferlib=pufferlib)
    for name, make in _MAKERS.items():
        try:
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                found = list(make(sizes))
                for subject in found:
                    subject.step()
            subjects += found
        except ModuleNotFoundError as error:
            skipped[name] = f"not installed: there is no module {error.name}"
        except Exception as error:  # noqa: BLE001 - other people's code may fail in any way; the run goes on and says so
            skipped[name] = f"{type(error).__name__}: {str(error).splitlines()[0] if str(error) else ''}"
    return subjects, skipped
