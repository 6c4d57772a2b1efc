"""The file: as docs/reference/replays.md says, small, and proof against whatever else it may hold."""

import copy
import hashlib
import json
import os
import re
import struct
import subprocess
import sys
import zlib
from contextlib import contextmanager, suppress
from dataclasses import fields
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
from catch_arena.replay.codec import Reader, pack_columns
from catch_arena.replay.fileformat import decode_replay
from catch_arena.replay.verification import verify

ONE_LINE = r"\A[ -~]+\Z"


def file_of(replay, folder) -> bytes:
    replay.save(folder / "made.replay")
    return (folder / "made.replay").read_bytes()


def body_of(content: bytes) -> bytes:
    return zlib.decompress(content[20:-32])


def sealed(body: bytes, *, packed_as: bytes | None = None, form: int = 2) -> bytes:
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
    """Header, actions, digests and every number of the states, in every kind of match."""
    match = play(scenario, max_cycles=60, **overrides)
    read = decode(file_of(match, tmp_path))

    assert read["config"] == json.loads(json.dumps(match.config.to_dict()))
    assert (read["seed"], tuple(read["names"]), read["title"]) == (match.seed, match.names, match.title)
    assert [tuple(pair) for pair in read["withdrawals"]] == match.withdrawals
    assert np.array_equal(np.array(read["ranks"]).T, np.array(match.choices))
    for seat, columns in read["commands"].items():
        assert np.array_equal(np.array(columns).T, np.array(match.commands)[:, seat])
    of_prey = np.array(read["prey_commands"]).reshape(match.config.prey, 2, match.steps)
    assert np.array_equal(of_prey.transpose(2, 0, 1), match.prey_commands)
    assert read["digests"] == match.digests
    assert read["states"] == [state.tolist() for state in match.states]


@pytest.mark.parametrize("which", ["mixed", "fleeing", "hunted"])
def test_a_quantised_state_is_the_state_in_whole_millionths(which, request):
    """At most half a millionth from the numbers that the digest stands for."""
    match = request.getfixturevalue(which)
    hunters, targets = 4 * ([1e6] * 7 + [1] * 4), [1, 1e6, 1e6, 1e6, 1]
    if which != "mixed":
        targets += [1e6, 1e6, 1]
    prey = [1] * 3 * match.config.prey
    for engine, quantised in zip(match.engines(), match.states, strict=True):
        state = engine.state()
        scale = np.array([1] * 8 + hunters + targets * ((len(state) - 52 - len(prey)) // len(targets)) + prey)
        assert np.abs(state * scale - quantised).max() <= 0.5 + 1e-6


@pytest.mark.parametrize(
    ("most", "overrides"),
    [
        (20_000, {"chase": True}),
        (26_000, {}),
        (30_000, {"control": "velocity"}),
        (30_000, {"control": "velocity", "reverse": True}),
        (32_000, {"control": "full"}),
        (32_000, {"control": "full", "reverse": True}),
        (30_000, {"chase": True, "target_motion": "wander"}),
        (33_000, {"chase": True, "target_motion": "flee"}),
        (52_000, {"control": "full", "target_motion": "wander"}),
        (56_000, {"control": "full", "target_motion": "flee"}),
        (30_000, {"chase": True, "prey": 1, "initial_targets": 1, "spawning": False}),
        (70_000, {"chase": True, "prey": 4, "target_motion": "wander"}),
        (90_000, {"control": "full", "prey": 4, "target_motion": "wander"}),
    ],
)
def test_a_minute_of_four_hunters_is_small(play, tmp_path, most, overrides):
    """Random commands are the worst case: 26 bits of each float32 are noise. So are 20 of a new turn rate, and nobody
    catches the targets of those who drive at random.
    """
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


def test_a_file_from_before_targets_could_move_plays_as_recorded():
    """Its config has fewer settings; those that are new are at their defaults."""
    path = Path(__file__).parents[1] / "data" / "before_moving_targets.replay"
    old = Replay.load(path)

    assert "view_angle_deg" not in decode(path.read_bytes())["config"]
    assert (old.config.target_motion, old.steps) == ("still", 100)
    assert verify(old) == []


OLD_FILES = sorted((Path(__file__).parents[1] / "data" / "replays").iterdir())


@pytest.mark.parametrize("path", OLD_FILES, ids=lambda path: path.stem)
def test_a_file_of_an_earlier_version_plays_as_recorded_and_is_kept_in_its_format(path, tmp_path):
    """Plain, with targets that move, teams, prey, and requests by name; the file's name begins with its format."""
    old = Replay.load(path)
    assert old.steps > 50
    assert verify(old) == []
    saved = file_of(old, tmp_path)
    assert saved[8] == path.read_bytes()[8] == int(path.name[0])
    assert {**decode(saved), "package": ""} == {**decode(path.read_bytes()), "package": ""}


def test_files_of_all_formats_are_kept():
    assert {int(path.name[0]) for path in OLD_FILES} == {2, 3, 4, 5}


def test_any_match_is_read_as_it_was_written(tmp_path):
    """Settings, actions and dropouts from all over their ranges, the quantised state of every number included."""
    for seed in range(60 * EFFORT):
        source = Random(seed)
        config = some_config(source)
        match = Replay(config, source.getrandbits(64), config.hunter_names + config.prey_names)
        engine = Engine(config)
        engine.reset([match.seed])
        match.note(engine)
        while match.steps < 30 and not engine.ends[0]:
            choices, commands = some_batch_actions(source, config, 1)
            choices[:, [control == "velocity" for control in config.controls]] = 0
            commands[:, : config.hunters][:, [control == "target" for control in config.controls]] = 0.0
            engine.step(choices, commands)
            match.append(choices[0], commands[0], engine)
        match.save(tmp_path / "any.replay")
        loaded = Replay.load(tmp_path / "any.replay")
        assert all(map(np.array_equal, loaded.states, match.states)), settings_of(config)
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
    config = catch_arena.ArenaConfig(hunters=2, control_period_ms=86_400_000, time_limit_s=1e6)
    ranks, commands = np.zeros(2, dtype=np.int64), np.zeros((2, 2), dtype=np.float32)
    with pytest.raises(OutputError, match="2 steps of 86400000 ms are more than a day"):
        Replay(config, 1, ("a", "b"), choices=[ranks] * 2, commands=[commands] * 2).save(tmp_path / "long.replay")
    assert list(tmp_path.iterdir()) == []


@given(st.lists(st.lists(st.integers(-(2**63), 2**63 - 1), min_size=3, max_size=3)))
def test_columns_hold_any_whole_numbers(columns):
    """Of 64 bits, the extremes among them."""
    reader = Reader(pack_columns(np.array(column, dtype=np.int64) for column in columns))

    assert reader.columns(len(columns), 3).T.tolist() == columns
    reader.end()


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
    ("content", "says"),
    [
        (b"", "is not a Catch Arena replay"),
        (b"PK\x03\x04 something else", "is not a Catch Arena replay"),
        (b"\x89CATCH\r\n" + bytes(9), "is truncated"),
        (
            b"\x89CATCH\r\n" + struct.pack("<IQ", 1, 5) + bytes(37),
            "has format 1, but this version reads formats 2 to 5",
        ),
        (b"\x89CATCH\r\n" + struct.pack("<IQ", 2, 2**63) + bytes(37), "must be 9223372036854775860 bytes long"),
        (sealed(b"", packed_as=b"not zlib"), "its body does not unpack"),
        (sealed(b"", packed_as=zlib.compress(bytes(9))[:-1]), "is damaged"),
        (sealed(b"", packed_as=zlib.compress(bytes(9)) + b"more"), "4 bytes follow its body"),
        (sealed(b""), "before the end of its parts"),
        (sealed(b"\x00\x00\x00\x00"), "no readable header"),
        (sealed(b"\xff\xff\xff\xff{}"), "its header is 4294967295 bytes long"),
        (sealed(b"\x02\x00\x00\x00\xff\xfe"), "no readable header"),
        (sealed(b"\x02\x00\x00\x0012"), "its header is not a table"),
        (sealed(struct.pack("<I", 60_000) + b"[" * 60_000), "no readable header"),
        (sealed(struct.pack("<I", 60_000) + b'{"a":' * 12_000), "no readable header"),
        (sealed(struct.pack("<I", 10_000) + b"9" * 10_000), "no readable header"),
    ],
)
def test_what_is_no_replay_is_refused_with_its_reason(tmp_path, content, says):
    """Foreign, older, lying about its size, packed wrongly, nested without end."""
    assert says in refusal(content, tmp_path)


def test_only_a_match_with_prey_or_requests_by_name_is_kept_in_a_format_that_has_them(
    small, small_hunted, named, tmp_path
):
    assert (small[8], small_hunted[8], file_of(named, tmp_path)[8]) == (2, 3, 4)


def test_requests_by_name_are_read_by_the_document_alone(named, tmp_path):
    """Names of every kind, among them those that are no text and those that no UTF-8 holds."""
    read = decode(file_of(named, tmp_path))

    assert read["named_requests"] == named.named_requests
    assert {len(name or "") for _, _, name in read["named_requests"]} >= {0, 256}
    assert {"\ud800", None} <= {name for _, _, name in read["named_requests"]}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda asked: asked.__setitem__(0, asked[0]._replace(seat=1)), "that no hunter could have made"),
        (lambda asked: asked.__setitem__(0, asked[0]._replace(seat=-1)), "that no hunter could have made"),
        (lambda asked: asked.__setitem__(0, asked[0]._replace(step=10**6)), "not in the order of the steps"),
        (lambda asked: asked.__setitem__(0, asked[0]._replace(step=-1)), "not in the order of the steps"),
        (lambda asked: asked.reverse(), "not in the order of the steps"),
        (lambda asked: asked.__setitem__(0, asked[0]._replace(name="x" * 257)), "names that a replay cannot contain"),
        (lambda asked: asked.__setitem__(0, asked[0]._replace(name=7)), "names that a replay cannot contain"),
        (lambda asked: asked.extend([asked[-1]] * 2**16), "must contain 1 to 65536"),
    ],
)
def test_requests_by_name_that_cannot_be_are_refused(named, tmp_path, change, says):
    """Of a hunter under another control, after the end, in another order, of names that were not cut, too many."""
    assert says in refusal(rebuilt(named, tmp_path, lambda match: change(match.named_requests)), tmp_path)


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (struct.pack("<I", 2**31), "its table of names is 2147483648 bytes long"),
        (struct.pack("<I", 2) + b"\xff\xfe", "no readable table of names"),
        (struct.pack("<I", 9000) + b"[" * 9000, "no readable table of names"),
        (struct.pack("<I", 2) + b"[]" + struct.pack("<I", 0), "contains 0 requests by name"),
        (struct.pack("<I", 2) + b"[]" + struct.pack("<I", 1) + bytes(3), "that no hunter could have made"),
        (struct.pack("<I", 2) + b"{}", "names that a replay cannot contain"),
    ],
)
def test_a_table_of_names_that_lies_is_refused(play, tmp_path, table, says):
    """In the place where requests by name stand: behind the commands, before the digests."""
    content = file_of(play("duel", max_cycles=3, control="full"), tmp_path)
    match, body = decode_replay(content), body_of(content)
    at = body.index(match.digests[0])
    assert says in refusal(sealed(body[:at] + table + body[at:], form=4), tmp_path)


def test_a_format_that_is_not_that_of_its_match_is_refused(small, small_hunted, tmp_path):
    """Somebody has changed the number and sealed the file anew; or the number of prey."""
    assert refusal(sealed(body_of(small), form=3), tmp_path) == "has format 3, which does not fit a match with 0 prey"
    text = refusal(sealed(body_of(small_hunted), form=2), tmp_path)
    assert text == "has format 2, which does not fit a match with 2 prey"
    assert "has format 6, but this version reads formats 2 to 5" in refusal(sealed(b"", form=6), tmp_path)
    names = ["a", "b"]
    config = {**decode(small_hunted)["config"], "prey": 0}
    text = refusal(with_header(small_hunted, config=config, names=names, withdrawals=[]), tmp_path)
    assert text == "has format 3, which does not fit a match with 0 prey"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"names": ["a", "b", "c"]}, "names must have 4 entries, one for each hunter and each prey"),
        ({"names": ["a", "b", "c", "\x00"]}, "names[3] must be at most 200 printable characters"),
        ({"withdrawals": [[2, 4]]}, "withdrawals must name agents, each once"),
    ],
)
def test_a_header_of_a_match_with_prey_counts_all_agents(small_hunted, tmp_path, changes, says):
    assert says in refusal(with_header(small_hunted, **changes), tmp_path)


def test_one_bad_setting_of_prey_is_named(small_hunted, tmp_path):
    config = decode(small_hunted)["config"]
    text = refusal(with_header(small_hunted, config={**config, "prey": 33}), tmp_path)
    assert "prey must be a whole number from 0 to 32, got 33" in text
    text = refusal(with_header(small_hunted, config={**config, "teams": [[0], [0, 1]]}), tmp_path)
    assert "teams must name each seat from 0 to 1 once, got seat 0 more than once" in text


CONFIG = catch_arena.ArenaConfig(hunters=2).to_dict()


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"ruleset": "catch_arena_v9\n"},
            r"recorded under ruleset 'catch_arena_v9\n', but this version plays 'catch_arena_v1'",
        ),
        ({"ruleset": ...}, "was recorded under ruleset None"),
        ({"title": ...}, "missing required field `title`"),
        ({"extra\x1b": 1}, r"unknown field `extra\x1b`"),
        ({"title": "\x1b[2J"}, "title must be at most 200 printable characters"),
        ({"names": ["a", "b\r"]}, "names[1] must be at most 200 printable characters"),
        ({"names": ["a"]}, "names must have 2 entries"),
        ({"names": "ab"}, "names must have 2 entries"),
        ({"names": ["a", None]}, "names[1] must be"),
        ({"seed": -1}, "seed must be a whole number"),
        ({"seed": 2**64}, "seed must be a whole number"),
        ({"seed": True}, "seed must be a whole number"),
        ({"seed": 1.0}, "seed must be a whole number"),
        ({"steps": -1}, "`int` >= 0 - at `$.steps`"),
        ({"steps": 1.5}, "got `float` - at `$.steps`"),
        ({"steps": None}, "got `null` - at `$.steps`"),
        ({"steps": 4}, "4 steps, but a match has at most 3"),
        ({"steps": 2}, "is damaged"),
        ({"steps": 10**7}, "is too long for a file"),
        ({"steps": 2**31}, "<= 2147483647 - at `$.steps`"),
        ({"spans": 2**31 - 1}, "is too long for a file: 2147483647 targets"),
        ({"spans": 0}, "bytes follow its end"),
        ({"spans": -1}, "`int` >= 0 - at `$.spans`"),
        ({"withdrawals": [[2, 2]]}, "withdrawals must name agents"),
        ({"withdrawals": [[4, 1]]}, "withdrawals must name agents"),
        ({"withdrawals": [[2, 1], [1, 0]]}, "in the order of the steps"),
        ({"withdrawals": [[1, 1], [2, 1]]}, "each once"),
        ({"withdrawals": [[-1, 1]]}, "`int` >= 0 - at `$.withdrawals[0][0]`"),
        ({"withdrawals": [[1]]}, "cannot be used"),
        ({"withdrawals": 7}, "cannot be used"),
        ({"config": None}, "cannot be used"),
        ({"config": []}, "cannot be used"),
        ({"config": {**CONFIG, "hunters": 10**9}}, "hunters must be a whole number from 1 to 64"),
        ({"config": {**CONFIG, "hunters": "2"}}, "hunters must be a whole number"),
        ({"config": {**CONFIG, "hunters": [2]}}, "hunters must be a whole number"),
        ({"config": {**CONFIG, "gains": {"kp_v": []}}}, "gains.kp_v must be a finite number"),
        ({"config": {**CONFIG, "gains": 3}}, "gains must be Gains"),
        ({"config": {**CONFIG, "side_m": float("nan")}}, "side_m must be a finite number"),
        ({"config": {**CONFIG, "side_m": 10**400}}, "side_m must be at least 2"),
        ({"config": {**CONFIG, "control": {"a": 1}}}, "control must be"),
        ({"config": {**CONFIG, "control": [["target"], "full"]}}, "control[0] must be one of"),
        ({"config": {**CONFIG, "policy": "x" * 60_000}}, "policy must be one of"),
        ({"config": {**CONFIG, "policy": ["nearest"]}}, "policy must be one of"),
        ({"config": {**CONFIG, "hunter_poses": [[1, 2], 3]}}, "hunter_poses[0] must be"),
        ({"config": {**CONFIG, "hunter_poses": "ab"}}, "hunter_poses must be 2 poses"),
        ({"config": {**CONFIG, "start_radius_m": "1"}}, "start_radius_m must be"),
        ({"config": {**CONFIG, "name_prefix": "\x07"}}, "name_prefix must be at most 200 printable"),
        ({"config": {**CONFIG, "nonsense": 1}}, "unknown setting 'nonsense'"),
        ({"config": {**CONFIG, "control_period_ms": 10**9}}, "more than a day"),
    ],
)
def test_a_header_that_cannot_be_is_refused_with_its_field(small, tmp_path, changes, says):
    """The checksum is right: somebody has made this file."""
    text = refusal(with_header(small, **changes), tmp_path)

    assert says in text, text


def rebuilt(replay: Replay, folder: Path, change) -> bytes:
    """The file of a match that was changed in memory, where nothing is checked."""
    twin = copy.deepcopy(replay)
    change(twin)
    return file_of(twin, folder)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda match: match.choices[3].__setitem__(0, 9), "contains actions of hunter_0"),
        (lambda match: match.choices[3].__setitem__(0, -1), "contains actions of hunter_0"),
        (lambda match: match.choices[3].__setitem__(1, 1), "contains actions of hunter_1"),
        (lambda match: match.choices[3].__setitem__(3, 2**62), "contains actions of hunter_3"),
        (lambda match: match.commands[3].__setitem__((1, 0), np.nan), "contains velocity commands"),
        (lambda match: match.commands[3].__setitem__((2, 1), np.inf), "contains velocity commands"),
        (lambda match: match.commands[3].__setitem__((2, 1), -1.0000001), "contains velocity commands"),
        (lambda match: match.states[3].__setitem__(9, 2**60), "a number beyond 2^53"),
        (lambda match: match.states[3].__setitem__(12, -(2**60)), "a number beyond 2^53"),
        (lambda match: match.states[3].__setitem__(-5, match.states[3][-10]), "cannot be alive together"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast:RuntimeWarning")  # a NaN is made on purpose
def test_actions_and_numbers_that_cannot_be_are_refused(mixed, tmp_path, change, says):
    """NaN, infinity, ranks that nobody sees, commands of those who give none, numbers without measure."""
    assert says in refusal(rebuilt(mixed, tmp_path, change), tmp_path)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda match: match.prey_commands[3].__setitem__((1, 0), np.nan), "contains velocity commands"),
        (lambda match: match.prey_commands[3].__setitem__((2, 1), 1.0000001), "contains velocity commands"),
        (lambda match: match.states[3].__setitem__(-1, 2**60), "a number beyond 2^53"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value encountered in cast:RuntimeWarning")  # a NaN is made on purpose
def test_commands_and_numbers_of_prey_that_cannot_be_are_refused(hunted, tmp_path, change, says):
    assert says in refusal(rebuilt(hunted, tmp_path, change), tmp_path)


@contextmanager
def named_in_one_line():
    """A ReplayError's text has no line break and no control character."""
    try:
        yield
    except ReplayError as error:
        if not re.match(ONE_LINE, str(error)):
            raise AssertionError(repr(str(error))) from error
        raise


def load_and_play(content: bytes, folder: Path) -> None:
    """Any other error than a ReplayError of one line fails."""
    path = folder / "fuzzed.replay"
    path.write_bytes(content)
    with suppress(ReplayError), named_in_one_line():
        for _ in Replay.load(path).worlds():
            pass


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
    load_and_play(sealed(bytes(body), form=content[8]), tmp_path)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=200 * EFFORT, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_json_in_a_header_loads_and_plays_or_is_refused(small, tmp_path, data):
    """Any entry of the header or any setting, as anything that JSON can say."""
    header = decode(small)
    if data.draw(st.booleans()):
        changes = {
            data.draw(
                st.sampled_from(["seed", "names", "title", "steps", "withdrawals", "spans", "config"])
            ): data.draw(JSON)
        }
    else:
        setting = data.draw(st.sampled_from(sorted(header["config"])))
        changes = {"config": {**header["config"], setting: data.draw(JSON)}}
    load_and_play(with_header(small, **changes), tmp_path)


LIMITED = """
import resource, sys, time
from catch_arena import ArenaConfig, Engine, Replay
from catch_arena.errors import ReplayError
from catch_arena.replay.verification import verify
resource.setrlimit(resource.RLIMIT_AS, (1 << 30, 1 << 30))
Engine(ArenaConfig())
for path in sys.argv[1:]:
    began = time.process_time()
    try:
        replay = Replay.load(path)
        outcome = f"loaded: {verify(replay)[0]}"
    except ReplayError as error:
        outcome = str(error).removeprefix(f"{path}: ")
    print(f"{time.process_time() - began:.1f}|{outcome}")
"""


def longest_steps(config: dict) -> int:
    """The steps of the longest match of these settings that is read."""
    of_target = 5 if config["target_motion"] == "still" else 8
    numbers = 8 + 11 * config["hunters"] + of_target * config["max_targets"]
    return min((1 << 23) // numbers - 1, 86_400_000 // config["control_period_ms"])


def longest(small: bytes, columns: bytes = b"", spans: bytes = bytes(7), **settings) -> bytes:
    """That match, well-formed; all zeros, or with these columns of hunters."""
    config = {**CONFIG, "control": "full", "max_cycles": 10**9, **settings}
    hunters, steps = config["hunters"], longest_steps(config)
    if columns:
        columns = b"".join(b"\x03" + columns[at : at + 3 * (steps + 1)] for at in range(11 * hunters))
    states = bytes(8) + (columns or bytes(11 * hunters)) + spans
    return match_file(small, config, steps, states, 0 if spans == bytes(7) else 1 << 18)


def herd(small: bytes) -> bytes:
    """Targets that live from the beginning to the end of the longest match, and move as much as numbers can say."""
    config = {**CONFIG, "hunters": 1, "control": "full", "max_cycles": 10**9, "target_motion": "flee"}
    config |= {"max_targets": 64, "initial_targets": 64}
    steps = longest_steps(config)
    clock = pack_columns([np.full(steps + 1, 1000)]) + bytes(7)
    spans = pack_columns(np.array([[0] * 64, [steps + 1] * 64, range(64), [0] * 64]))
    motion = np.random.default_rng(5).bytes(1 << 20) * 8
    tracks = b"".join(b"\x01" + motion[at : at + 64 * (steps + 1)] for at in range(6))
    return match_file(small, config, steps, clock + bytes(11) + spans + tracks, 64)


def match_file(small: bytes, config: dict, steps: int, states: bytes, spans: int) -> bytes:
    """A file in which everybody does nothing."""
    hunters = config["hunters"]
    header = {**{name: decode(small)[name] for name in ("ruleset", "package", "seed", "title")}, "config": config}
    header |= {"names": [""] * hunters, "steps": steps, "withdrawals": [], "spans": spans}
    text = json.dumps(header).encode()
    return sealed(struct.pack("<I", len(text)) + text + bytes(3 * hunters) + bytes(8 * steps + 8) + states)


def most_spans() -> bytes:
    """As many targets as a file may hold, 64 new ones in each state."""
    table = np.ones((7, 1 << 18), dtype=np.int64)
    table[0] = np.arange(1 << 18) % 64 == 0
    table[0, 0] = 0
    table[2] = np.arange(1 << 18)
    return pack_columns(table)


def test_hostile_files_take_neither_memory_nor_time(small, tmp_path):
    """A process that may have 1 GiB of address space; every bomb is refused or played, in seconds."""
    bomb = zlib.compressobj(9)
    crowd = {"hunters": 64, "max_targets": 64, "initial_targets": 64}
    files = {
        "bomb": sealed(b"", packed_as=b"".join(bomb.compress(bytes(1 << 20)) for _ in range(128)) + bomb.flush()),
        "long": bytes(1 << 27),
        "steps": with_header(small, steps=10**7),
        "spans": with_header(small, spans=2**18),
        "json": sealed(struct.pack("<I", 65_000) + b'{"a":[' + b"[],[{}]," * 8124),
        "dense": longest(small, np.random.default_rng(5).bytes(1 << 20), most_spans(), **crowd),
        "herd": herd(small),
    }
    if EFFORT > 1:
        files["crowd"] = longest(small, spawn_frequency_hz=1e6, **crowd)
        files["most"] = longest(small, hunters=1, max_targets=1, initial_targets=0)
        files["slow"] = longest(small, hunters=64, max_targets=1, initial_targets=0, control_period_ms=86_400_000)
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
    played = {name for name, (_, text) in outcomes.items() if text.startswith("loaded")}
    assert played == files.keys() & {"most", "crowd", "dense", "slow", "herd"}, outcomes
    assert all(float(seconds) < 60 for seconds, _ in outcomes.values()), outcomes
