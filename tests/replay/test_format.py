"""A replay file is as docs/reference/replays.md says, and everything else is refused with one line."""

import copy
import hashlib
import json
import os
import re
import struct
import subprocess
import sys
import zlib
from dataclasses import fields
from io import BytesIO
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from properties.matches import EFFORT, settings_of, some_batch_actions, some_config
from replay.decoder import decode

import catch_arena
from catch_arena import Replay
from catch_arena.engine import Engine
from catch_arena.errors import OutputError, ReplayError
from catch_arena.replay.codec import pack_columns, read_columns
from catch_arena.replay.comparison import verify
from catch_arena.replay.fileformat import decode_replay

ONE_LINE = r"\A[ -~]+\Z"


def file_of(replay, folder) -> bytes:
    replay.save(folder / "made.replay")
    return (folder / "made.replay").read_bytes()


def body_of(content: bytes) -> bytes:
    return zlib.decompress(content[20:-32])


def sealed(body: bytes, *, packed_as: bytes | None = None, form: int = 6) -> bytes:
    """A file with a right length and a right checksum around any body."""
    shrunk = zlib.compress(body) if packed_as is None else packed_as
    content = b"\x89CATCH\r\n" + struct.pack("<IQ", form, len(shrunk)) + shrunk
    return content + hashlib.blake2b(content, digest_size=32).digest()


def with_header(content: bytes, **changes) -> bytes:
    """The same file with another header; `...` takes an entry away."""
    body = body_of(content)
    (length,) = struct.unpack_from("<I", body)
    header = {**json.loads(body[4 : 4 + length]), **changes}
    text = json.dumps({name: value for name, value in header.items() if value is not ...}).encode()
    return sealed(struct.pack("<I", len(text)) + text + body[4 + length :], form=content[8])


def refusal(content: bytes, folder: Path) -> str:
    """The line with which a file is refused."""
    path = folder / "bad.replay"
    path.write_bytes(content)
    with pytest.raises(ReplayError, match=r"bad\.replay: ") as caught:
        Replay.load(path)
    text = str(caught.value).removeprefix(f"{path}: ")
    assert re.match(ONE_LINE, text)
    assert len(text) < 500
    return text


@pytest.fixture(scope="module")
def small(play, tmp_path_factory) -> bytes:
    """A file of a few steps."""
    match = play("duel", max_cycles=3, control=("full", "target"), withdraw={2: ["hunter_1"]})
    return file_of(match, tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="module")
def small_moving(play, tmp_path_factory) -> bytes:
    """Another, in which targets move."""
    match = play("duel", max_cycles=3, control=("full", "target"), target_motion="flee")
    return file_of(match, tmp_path_factory.mktemp("moving"))


@pytest.fixture(scope="module")
def small_hunted(play, tmp_path_factory) -> bytes:
    """Another, with prey that is caught and returns."""
    match = play("duel", max_cycles=6, prey=2, prey_returns_s=0.1, reach_m=9.0, chase=True, withdraw={2: ["prey_1"]})
    return file_of(match, tmp_path_factory.mktemp("hunted"))


# what a file is


@pytest.mark.parametrize(
    ("scenario", "overrides"),
    [
        ("faulty", {"control": ("target", "velocity", "full", "target"), "withdraw": {20: ["hunter_1"]}}),
        ("standard", {"control": "full", "reverse": True, "control_period_ms": 250}),
        ("standard", {"control": "velocity", "control_period_ms": 1100, "side_m": 2.0}),
        ("capstone", {"hunters": 2}),
        ("duel", {"reach_m": 3.0, "spawn_frequency_hz": 30.0, "mask_in_observation": True}),
        ("duel", {"side_m": 5000.0, "max_speed_mps": 1000.0, "max_turn_rate_radps": 1000.0, "control": "full"}),
        ("standard", {"target_motion": "wander", "spawn_frequency_hz": 7.0, "chase": True}),
        ("faulty", {"target_motion": "flee", "control": "full", "dropout_rate": 0.02, "view_angle_deg": 90.0}),
        ("duel", {"target_motion": "flee", "control": "velocity", "control_period_ms": 1700, "reach_m": 2.0}),
        ("duel", {"target_motion": "wander", "target_speed_mps": 1000.0, "target_turn_rate_radps": 1000.0}),
        ("duel", {"target_motion": "flee", "initial_targets": 0, "time_limit_s": 0.5}),
        ("duel", {"control": "full", "max_speed_mps": (1.0, 3.0), "max_turn_rate_radps": (9.0, 2.0), "reverse": True}),
        ("standard", {"prey": 3, "reach_m": 1.5, "chase": True, "withdraw": {20: ["prey_1"], 30: ["hunter_2"]}}),
        ("standard", {"prey": 2, "reach_m": 2.0, "chase": True, "prey_returns_s": 0.0, "target_motion": "flee"}),
        (
            "duel",
            {"prey": 2, "reach_m": 2.0, "chase": True, "prey_returns_s": None, "reverse": True, "spawning": False},
        ),
        ("standard", {"teams": ((0, 2), (1, 3)), "team_share": 0.5}),
    ],
)
def test_a_decoder_by_the_document_alone_reads_the_same(play, tmp_path, scenario, overrides):
    """Header, actions and digests, in every kind of match."""
    match = play(scenario, max_cycles=60, **overrides)
    read = decode(file_of(match, tmp_path))

    assert read["config"] == json.loads(json.dumps(match.config.to_dict()))
    assert (read["seed"], tuple(read["names"]), read["title"]) == (match.seed, match.names, match.title)
    assert [tuple(pair) for pair in read["withdrawals"]] == match.withdrawals
    assert np.array_equal(np.array(read["ranks"]).T, np.array(match.choices))
    for seat, columns in read["commands"].items():
        assert np.array_equal(np.array(columns).T, np.array(match.commands)[:, seat])
    of_prey = np.array(read["prey_commands"]).reshape(match.config.prey, 2, match.steps)
    assert np.array_equal(of_prey.transpose(2, 0, 1), np.array(match.commands)[:, match.config.hunters :])
    assert read["digests"] == match.digests


@pytest.mark.parametrize(
    ("most", "overrides"),
    [
        (8_000, {}),
        (24_000, {"control": "velocity"}),
        (25_000, {"control": "full"}),
        (44_000, {"control": "full", "prey": 4, "target_motion": "wander"}),
    ],
)
def test_a_minute_of_four_hunters_is_small(play, tmp_path, most, overrides):
    """Random commands are the worst case: 26 bits of each float32 are noise."""
    match = play(**overrides)

    assert match.steps == 600
    assert len(file_of(match, tmp_path)) < most


@pytest.mark.parametrize("which", ["mixed", "fleeing", "hunted", "hunted_once", "named"])
def test_a_replay_is_the_same_after_saving_and_loading(which, request, tmp_path):
    """Everything, and the file that it is saved to again."""
    match = request.getfixturevalue(which)
    first = file_of(match, tmp_path)
    loaded = Replay.load(tmp_path / "made.replay")

    assert file_of(loaded, tmp_path) == first
    for name in (field.name for field in fields(Replay)):
        assert repr(getattr(loaded, name)) == repr(getattr(match, name)), name


OLD_FILES = sorted((Path(__file__).parents[1] / "data" / "replays").iterdir())


@pytest.mark.parametrize("path", OLD_FILES, ids=lambda path: path.stem)
def test_a_file_of_an_earlier_version_plays_as_recorded(path, tmp_path):
    """Matches with and without moving targets, teams, prey and requests by name; the name begins with the format."""
    old = Replay.load(path)
    assert old.steps > 50
    assert path.read_bytes()[8] == int(path.name[0])
    assert verify(old) == []
    old.save(tmp_path / "new.replay")
    assert Replay.load(tmp_path / "new.replay") == old


def test_any_match_is_read_as_it_was_written(tmp_path):
    """Settings, actions and dropouts from all over their ranges."""
    for seed in range(60 * EFFORT):
        source = Random(seed)
        config = some_config(source)
        match = Replay(config, source.getrandbits(64), config.hunter_names + config.prey_names)
        engine = Engine(config)
        engine.reset([match.seed])
        match.digests.append(engine.digest())
        while match.steps < 30 and not engine.ends[0]:
            choices, commands = some_batch_actions(source, config, 1)
            choices[:, [control == "velocity" for control in config.controls]] = 0
            commands[:, : config.hunters][:, [control == "target" for control in config.controls]] = 0.0
            engine.step(choices, commands)
            match.append(choices[0], commands[0], engine)
        match.save(tmp_path / "any.replay")
        loaded = Replay.load(tmp_path / "any.replay")
        assert loaded == match, settings_of(config)
        assert verify(loaded) == [], settings_of(config)


def test_a_match_that_is_not_over_is_kept_as_far_as_it_went(tmp_path):
    """From no step at all; a withdrawal that nothing follows is kept too."""
    env = catch_arena.parallel_env("duel")
    env.record()
    env.reset(seed=4)
    for steps in range(3):
        file_of(env.replay(), tmp_path)
        loaded = Replay.load(tmp_path / "made.replay")
        assert loaded.steps == steps
        *_, last = loaded.worlds()
        assert last == env.world()
        env.step(dict.fromkeys(env.agents, 1))
    env.withdraw("hunter_0")
    file_of(env.replay(), tmp_path)
    assert Replay.load(tmp_path / "made.replay").withdrawals == [(3, 0)]


def test_what_could_not_be_read_again_is_not_recorded(tmp_path):
    """Names that break a line at `record`, a match that is too long at `save`; nothing is left behind."""
    env = catch_arena.parallel_env("duel")
    for names in (["a\nb", "c"], ["\x1b[2J", "c"], ["\udc80", "c"], ["x" * 201, "c"], [1, "c"], ["a"]):
        with pytest.raises(catch_arena.CatchArenaError, match=r"^names"):
            env.record(names)
    with pytest.raises(catch_arena.CatchArenaError, match=r"^title must be at most 200 printable characters"):
        env.record(title="a\tb")
    long, steps = Replay(catch_arena.ArenaConfig(hunters=64), 1, tuple(f"{seat}" for seat in range(64))), 120_000
    long.choices, long.commands = [np.zeros(64, dtype=np.int64)] * steps, [np.zeros((64, 2), dtype=np.float32)] * steps
    with pytest.raises(OutputError, match="is too long for a file: 120000 steps, but at most 116508 fit"):
        long.save(tmp_path / "long.replay")
    assert list(tmp_path.iterdir()) == []


@given(st.lists(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=3, max_size=3)))
def test_columns_hold_any_whole_numbers(columns):
    body = BytesIO(pack_columns(np.array(column, dtype=np.int64) for column in columns))

    assert read_columns(body, len(columns), 3).T.tolist() == columns
    assert body.read() == b""


# what is not a file


def test_every_truncation_is_refused(small):
    """At every length."""
    for length in range(len(small)):
        with pytest.raises(ReplayError, match=ONE_LINE):
            decode_replay(small[:length])


def test_every_flipped_bit_is_refused(small):
    """Each single one."""
    for at in range(len(small)):
        for bit in range(8):
            flipped = bytearray(small)
            flipped[at] ^= 1 << bit
            with pytest.raises(ReplayError, match=ONE_LINE):
                decode_replay(bytes(flipped))


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "is not a Catch Arena replay"),
        (b"PK\x03\x04 something else", "is not a Catch Arena replay"),
        (b"\x89CATCH\r\n" + bytes(9), "is incomplete or damaged"),
        (sealed(b"", form=1), "has format 1, but this version reads formats 2 to 6"),
        (sealed(b"", form=7), "has format 7, but this version reads formats 2 to 6"),
        (sealed(b"", packed_as=b"not zlib"), "is damaged: its parts do not fit together"),
        (sealed(b"", packed_as=zlib.compress(bytes(9))[:-1]), "is damaged"),
        (sealed(b""), "its parts do not fit together"),
        (sealed(b"\xff\xff\xff\xff{}"), "a JSON text is 4294967295 bytes long, more than 65536"),
        (sealed(b"\x02\x00\x00\x00\xff\xfe"), "its parts do not fit together"),
        (sealed(b"\x02\x00\x00\x0012"), "Expected `object`, got `int`"),
        (sealed(struct.pack("<I", 60_000) + b'{"a":' * 12_000), "its parts do not fit together"),
        (sealed(struct.pack("<I", 10_000) + b"9" * 10_000), "its parts do not fit together"),
    ],
)
def test_what_is_no_replay_is_refused_with_its_reason(tmp_path, content, reason):
    """Foreign, older, lying about its size, packed wrongly, nested without end."""
    assert reason in refusal(content, tmp_path)


def test_requests_by_name_are_read_by_the_document_alone(named, tmp_path):
    """Names of every kind, among them those that are no text and those that no UTF-8 holds."""
    read = decode(file_of(named, tmp_path))

    assert read["named_requests"] == named.named_requests
    assert {len(name or "") for _, _, name in read["named_requests"]} >= {0, 256}
    assert {"\ud800", None} <= {name for _, _, name in read["named_requests"]}


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda requests: requests.__setitem__(0, requests[0]._replace(seat=1)), "that no hunter could have made"),
        (lambda requests: requests.__setitem__(0, requests[0]._replace(name="x" * 257)), "`str` of length <= 256"),
        (lambda requests: requests.__setitem__(0, requests[0]._replace(name=7)), "Expected `str | null`, got `int`"),
        (lambda requests: requests.extend([requests[-1]] * 2**16), "must contain at most 65536"),
    ],
)
def test_requests_by_name_that_cannot_be_are_refused(named, tmp_path, change, reason):
    """Requests of another control, with names that are too long, or too many."""
    assert reason in refusal(rebuilt(named, tmp_path, lambda match: change(match.named_requests)), tmp_path)


CONFIG = catch_arena.ArenaConfig(hunters=2).to_dict()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (
            {"ruleset": "catch_arena_v9\n"},
            r"recorded under ruleset 'catch_arena_v9\n', but this version plays 'catch_arena_v1'",
        ),
        ({"title": ...}, "cannot be used: Object missing required field `title`"),
        ({"extra\x1b": 1}, r"unknown field `extra\x1b`"),
        ({"title": "\x1b[2J"}, "title must be at most 200 printable characters"),
        ({"names": ["a", "b\r"]}, "names[1] must be at most 200 printable characters"),
        ({"names": ["a", None]}, "names[1] must be"),
        ({"seed": -1}, "seed must be a whole number"),
        ({"seed": True}, "seed must be a whole number"),
        ({"steps": -1}, "`int` >= 0 - at `$.steps`"),
        ({"steps": 2}, "is damaged"),
        ({"steps": 10**7}, "is too long for a file"),
        ({"spans": "x"}, "Expected `int`, got `str` - at `$.spans`"),
        ({"withdrawals": [[2, 2]]}, "withdrawals or colors of agents that it does not have"),
        ({"colors": [1, 2, 3]}, "withdrawals or colors of agents that it does not have"),
        ({"withdrawals": [[-1, 1]]}, "`int` >= 0 - at `$.withdrawals[0][0]`"),
        ({"config": []}, "cannot be used"),
        ({"config": {**CONFIG, "hunters": 10**9}}, "hunters must be a whole number from 1 to 64"),
        ({"config": {**CONFIG, "gains": {"kp_v": []}}}, "gains.kp_v must be at least 0"),
        ({"config": {**CONFIG, "side_m": float("nan")}}, "side_m must be at least 2"),
        ({"config": {**CONFIG, "control": {"a": 1}}}, "control must be"),
        ({"config": {**CONFIG, "policy": "x" * 60_000}}, "policy must be one of"),
        ({"config": {**CONFIG, "hunter_poses": [[1, 2], 3]}}, "hunter_poses[0] must be"),
        ({"config": {**CONFIG, "name_prefix": "\x07"}}, "name_prefix must be at most 200 printable"),
        ({"config": {**CONFIG, "nonsense": 1}}, "unknown setting 'nonsense'"),
    ],
)
def test_a_header_that_cannot_be_is_refused_with_its_field(small, tmp_path, changes, reason):
    """The checksum is right: somebody has made this file."""
    text = refusal(with_header(small, **changes), tmp_path)

    assert reason in text, text


def rebuilt(replay: Replay, folder: Path, change) -> bytes:
    """The file of a match that was changed in memory, where nothing is checked."""
    twin = copy.deepcopy(replay)
    change(twin)
    return file_of(twin, folder)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda match: match.choices[3].__setitem__(0, 9), "contains ranks that no arena would accept"),
        (lambda match: match.choices[3].__setitem__(1, 1), "contains ranks that no arena would accept"),
        (lambda match: match.choices[3].__setitem__(3, 2**62), "contains ranks that no arena would accept"),
        (lambda match: match.commands[3].__setitem__((1, 0), np.nan), "contains velocity commands"),
        (lambda match: match.commands[3].__setitem__((2, 1), -1.0000001), "contains velocity commands"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast:RuntimeWarning")  # a NaN is made on purpose
def test_actions_that_cannot_be_are_refused(mixed, tmp_path, change, reason):
    """NaN, ranks beyond the view, commands beyond the limits."""
    assert reason in refusal(rebuilt(mixed, tmp_path, change), tmp_path)


@settings(max_examples=300 * EFFORT, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_whatever_is_sealed_loads_and_plays_or_is_refused(small, small_moving, small_hunted, tmp_path, data):
    """Bytes of the body replaced, removed, inserted or repeated, under a right checksum: no other error than ours."""
    content = data.draw(st.sampled_from([small, small_moving, small_hunted]))
    body = bytearray(body_of(content))
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(body) - 1))
        size = data.draw(st.integers(0, min(40, len(body) - at)))
        new = data.draw(
            st.binary(max_size=12) | st.sampled_from([b"\xff" * 8, b"\x08" * 9, bytes(40), b"1e999", b"[]"])
        )
        body[at : at + size] = new * data.draw(st.integers(0, 3))
    (tmp_path / "fuzzed.replay").write_bytes(sealed(bytes(body), form=content[8]))
    outcome = "it plays"
    try:
        for _ in Replay.load(tmp_path / "fuzzed.replay").worlds():
            pass
    except ReplayError as error:
        outcome = str(error)
    assert re.match(ONE_LINE, outcome), outcome


LIMITED = """
import resource, sys, time
from catch_arena import Replay
from catch_arena.errors import ReplayError
resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
for path in sys.argv[1:]:
    began = time.process_time()
    try:
        Replay.load(path)
        outcome = "loaded"
    except ReplayError as error:
        outcome = str(error).removeprefix(f"{path}: ")
    print(f"{time.process_time() - began:.1f}|{outcome}")
"""


def test_hostile_files_take_neither_memory_nor_time(small, tmp_path):
    """A process with 1 GiB of address space refuses each of them in seconds."""
    bomb = zlib.compressobj(9)
    files = {
        "bomb": sealed(b"", packed_as=b"".join(bomb.compress(bytes(1 << 20)) for _ in range(128)) + bomb.flush()),
        "long": bytes(1 << 27),
        "steps": with_header(small, steps=10**7),
        "json": sealed(struct.pack("<I", 65_000) + b'{"a":[' + b"[],[{}]," * 8124),
    }
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, *files],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,
        # compiled, whatever this process is; and each thread of a library would reserve address space
        env={**os.environ, "NUMBA_DISABLE_JIT": "0", "OPENBLAS_NUM_THREADS": "1"},
    )
    outcomes = dict(zip(files, (line.split("|", 1) for line in done.stdout.splitlines()), strict=True))
    assert not any(text.startswith("loaded") for _, text in outcomes.values()), outcomes
    assert all(float(seconds) < 60 for seconds, _ in outcomes.values()), outcomes
