"""LazyInfos that are made when they are asked for behave as the dicts that they stand for."""

import copy
import dataclasses
import json
import pickle
import time
from concurrent.futures import ThreadPoolExecutor
from threading import Event

import pytest

from catch_arena import parallel_env
from catch_arena.config import PreyRewardWeights, RewardWeights
from catch_arena.core.state import PART_NAMES, PREY_PART_NAMES
from catch_arena.envs.infos import LazyInfos

CONTENT = {"hunter_0": {"verdict": None}, "hunter_1": {"verdict": 3}}


def untold():
    infos = LazyInfos(dict.fromkeys(CONTENT))
    infos.make, infos.arguments = lambda content: {name: dict(info) for name, info in content.items()}, (CONTENT,)
    return infos


def a_dict_updated_from(infos):
    found = {}
    found.update(infos)
    return found


READERS = {
    "one": lambda infos: infos["hunter_1"] == CONTENT["hunter_1"],
    "get": lambda infos: infos.get("hunter_0") == CONTENT["hunter_0"],
    "in": lambda infos: "hunter_0" in infos,
    "len": lambda infos: len(infos) == 2,
    "iter": lambda infos: list(infos) == list(CONTENT),
    "reversed": lambda infos: list(reversed(infos)) == ["hunter_1", "hunter_0"],
    "keys": lambda infos: list(infos.keys()) == list(CONTENT),
    "values": lambda infos: list(infos.values()) == list(CONTENT.values()),
    "items": lambda infos: list(infos.items()) == list(CONTENT.items()),
    "==": lambda infos: infos == CONTENT,
    "== on the right": lambda infos: CONTENT == infos,  # noqa: SIM300 - that side is meant
    "!=": lambda infos: not infos != CONTENT,  # noqa: SIM202 - that operator is meant
    "bool": bool,
    "repr": lambda infos: repr(infos) == repr(CONTENT),
    "dict": lambda infos: dict(infos) == CONTENT,
    "unpacked": lambda infos: {**infos} == CONTENT,
    "|": lambda infos: (infos | {"a": 1}) == {**CONTENT, "a": 1} and ({"a": 1} | infos) == {"a": 1, **CONTENT},
    "updated from it": lambda infos: a_dict_updated_from(infos) == CONTENT,
    "copy": lambda infos: infos.copy() == CONTENT,
    "deepcopy": lambda infos: copy.deepcopy(infos) == CONTENT,
    "pickle": lambda infos: pickle.loads(pickle.dumps(infos)) == CONTENT,  # noqa: S301 - our own
    "json": lambda infos: json.loads(json.dumps(infos)) == CONTENT,
    "pop": lambda infos: infos.pop("hunter_1") == {"verdict": 3} and list(infos) == ["hunter_0"],
    "setdefault": lambda infos: infos.setdefault("hunter_1", {}) == {"verdict": 3},
}


@pytest.mark.parametrize("reader", READERS)
def test_infos_can_be_read_in_every_way(reader):
    """Each as the first that is done with them."""
    assert READERS[reader](untold())


def test_what_is_changed_before_the_first_look_stays_changed():
    """Filling them later would bring back what was deleted or overwritten."""
    for change in (lambda infos: infos.clear(), lambda infos: infos.popitem() and infos.popitem()):
        infos = untold()
        change(infos)
        assert not infos
    infos = untold()
    infos["hunter_0"] = {}
    del infos["hunter_1"]
    infos.update(a={})
    assert infos == {"hunter_0": {}, "a": {}}


@pytest.mark.parametrize("first", ["one", "dict", "copy"])
@pytest.mark.parametrize("reader", READERS)
def test_infos_can_be_read_again_as_any_dict(first, reader):
    """What comes after the first look is not slowed down by it, and keeps nothing of the step."""
    infos = untold()
    READERS[first](infos)

    assert READERS[reader](infos)
    assert type(infos).__getitem__ is dict.__getitem__
    assert not hasattr(infos, "make")


def test_parts_stand_in_the_order_of_the_rulebook():
    """That of the fields of the weights, of both sides."""
    env = parallel_env("tag")
    env.reset(seed=5)
    env._engine.parts[0], env._engine.prey_parts[0] = range(7), range(3)
    infos = env._observations_and_infos(env.agents)[1]

    assert infos["hunter_1"]["reward_parts"].tolist() == list(range(7))
    assert infos["prey_0"]["reward_parts"].tolist() == list(range(3))
    assert tuple(field.name for field in dataclasses.fields(RewardWeights)) == PART_NAMES
    assert tuple(field.name for field in dataclasses.fields(PreyRewardWeights)) == PREY_PART_NAMES


def test_infos_tell_of_their_own_step():
    """However late they are looked at."""
    env, again = parallel_env("crowd"), parallel_env("crowd")
    env.reset(seed=5)
    again.reset(seed=5)
    kept, seen = [], []
    for _ in range(60):
        actions = dict.fromkeys(env.agents, 1)
        kept.append(env.step(actions)[4])
        seen.append(json.dumps(again.step(actions)[4], default=lambda array: array.tolist()))

    assert [json.dumps(infos, default=lambda array: array.tolist()) for infos in kept] == seen
    assert len(set(seen)) == 60


def test_two_threads_may_be_the_first_to_read():
    """One makes the infos, and the other waits for them."""
    infos, begun, made = untold(), Event(), []
    make = infos.make

    def slow(content):
        made.append(content)
        begun.set()
        time.sleep(0.1)
        return make(content)

    infos.make = slow
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(infos.get, "hunter_1")
        begun.wait()
        second = pool.submit(READERS["items"], infos)
        assert first.result() == CONTENT["hunter_1"]
        assert second.result()
    assert len(made) == 1
