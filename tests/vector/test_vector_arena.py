"""The batch: many arenas play what one plays, whatever their number, rows and threads."""

import multiprocessing
import re
import threading
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from catch_arena import ArenaConfig, VectorArena, Verdict, parallel_env, scenario
from catch_arena.engine.episode_seeds import batch_seeds
from catch_arena.errors import ActionError, ConfigError, EpisodeError

SEED = 20_261_121
BUSY = ArenaConfig(hunters=5, side_m=4.0, max_targets=8, initial_targets=4, spawn_frequency_hz=4.0, time_limit_s=2.0)
HUNT = scenario(
    "standard",
    hunters=3,
    side_m=4.0,
    prey=3,
    initial_targets=5,
    max_targets=6,
    reach_m=0.6,
    reverse=True,
    prey_returns_s=0.4,
    prey_rewards={"survived": 0.1, "gained": 1.0},
    time_limit_s=2.0,
)
"""Much happens in both, and episodes are short."""
CONTROLS = ("target", "velocity", "full", ("target", "velocity", "full", "full", "target"))


def random_actions(config, num_envs, source):
    """Legal ones, as the config's control wants them."""
    catches = source.integers(0, config.targets_seen + 1, (num_envs, config.hunters))
    commands = source.uniform(-1, 1, (num_envs, config.hunters + config.prey, 2)).astype(np.float32)
    if set(config.controls) == {"target"} and not config.prey:
        return {"choices": catches}
    if set(config.controls) == {"velocity"}:
        return {"commands": commands}
    return {"choices": catches, "commands": commands}


def one_arenas_actions(config, actions, row):
    """Actions of one row, as the one-arena env takes them."""
    catches, commands = actions.get("choices"), actions.get("commands")
    kinds = {
        "target": lambda seat: int(catches[row, seat]),
        "velocity": lambda seat: commands[row, seat],
        "full": lambda seat: {"cmd_vel": commands[row, seat], "catch": int(catches[row, seat])},
    }
    hunters = {f"hunter_{seat}": kinds[control](seat) for seat, control in enumerate(config.controls)}
    return hunters | {f"prey_{index}": commands[row, config.hunters + index] for index in range(config.prey)}


def same(observation, row):
    """True if a row of the batch has the numbers of the env, and zeros after them."""
    return observation.tobytes() == row[: len(observation)].tobytes() and not row[len(observation) :].any()


@pytest.mark.rule("R12.7")
@pytest.mark.parametrize(
    "config",
    [
        *(BUSY.replace(control=control) for control in CONTROLS),
        *(HUNT, HUNT.replace(prey=1, prey_returns_s=None), HUNT.replace(hunters=12, prey_rewards={"gained": 0.0})),
    ],
)
def test_r12_7_a_row_plays_what_the_one_arena_env_plays_through_several_episodes(config):
    """Observations, rewards, masks, ends and who is active in every step, last observations and figures of every
    episode. Prey that is out for good keeps its row here, and has left there.
    """
    arena, row, source = VectorArena(config, 40), 37, np.random.default_rng(SEED)
    observations, infos = arena.reset(seed=SEED)
    env = parallel_env(config)
    seen, _ = env.reset(seed=int(batch_seeds(SEED, 40)[row]))
    hunters, places = config.hunters, {agent: place for place, agent in enumerate(env.possible_agents)}
    tally, won = np.zeros((hunters, len(Verdict))), np.zeros(hunters)
    returns, caught, episodes = np.zeros(len(places)), np.zeros(config.prey), 0
    for _ in range(3 * config.max_steps + 5):
        assert all(same(one, observations[row, places[agent]]) for agent, one in seen.items())
        actions = random_actions(config, 40, source)
        observations, rewards, terminations, truncations, infos = arena.step(**actions)
        given = one_arenas_actions(config, actions, row)
        seen, gained, ended, cut, notes = env.step({agent: given[agent] for agent in env.agents})
        assert all(rewards[row, places[agent]] == np.float32(reward) for agent, reward in gained.items())
        assert (terminations[row], truncations[row]) == (all(ended.values()), any(cut.values()))
        assert infos["_final_obs"][row] == (not env.agents)
        for agent, reward in gained.items():
            returns[places[agent]] += reward
        rulings = env.world().rulings
        assert arena.rulings(row) == (rulings if env.agents else ())
        for ruling in rulings:
            tally[ruling.hunter, ruling.verdict - 1] += 1
        won[list({ruling.winner for ruling in rulings if ruling.verdict is Verdict.LOST_CONTEST})] += 1
        masks = "action_mask" if env.agents else "final_mask"
        for agent, note in notes.items():
            if "action_mask" in note:
                assert (note["action_mask"] == infos[masks][row, places[agent]]).all()
            if agent.startswith("prey"):
                caught[places[agent] - hunters] += note["caught_by"] != -1
        if env.agents:
            if config.prey:
                in_play = [prey.target is not None for prey in env.world().prey]
                assert infos["active"][row].tolist() == [True] * hunters + in_play
            continue
        assert all(same(one, infos["final_obs"][row, places[agent]]) for agent, one in seen.items())
        figures = {name: values[row] for name, values in infos["episode"].items()}
        scores = np.array([hunter.score for hunter in env.world().hunters])
        assert (figures["length"] == config.max_steps).all()
        assert (figures["score"][:hunters] == scores).all()
        assert figures["rank"][:hunters].tolist() == [1 + (scores > score).sum() for score in scores]
        assert figures["rank"][hunters:].tolist() == [1 + (caught < times).sum() for times in caught]
        assert (figures["verdicts"][:hunters] == tally).all()
        assert (figures["contests_lost"][:hunters] == tally[:, Verdict.LOST_CONTEST - 1]).all()
        assert (figures["contests_won"][:hunters] == won).all()
        assert figures["return"][:hunters] == pytest.approx(returns[:hunters])
        np.testing.assert_allclose(figures["return"][hunters:], returns[hunters:], rtol=1e-5, atol=1e-5)
        if config.prey:
            assert figures["times_caught"].tolist() == caught.tolist()
        seen, _ = env.reset()
        tally[:], won[:], returns[:], caught[:], episodes = 0, 0, 0, 0, episodes + 1
    assert episodes == 3


@pytest.mark.parametrize("size", [1, 7, 33, pytest.param(100_000, marks=pytest.mark.large)])
def test_any_number_of_arenas_plays_alike(size):
    """The rows of a small batch and of a large one, and the last row, which may stand alone in its chunk."""
    config = BUSY.replace(hunters=2, max_targets=4)
    arena, few, source = VectorArena(config, size), VectorArena(config, 1), np.random.default_rng(SEED)
    seeds = batch_seeds(SEED, size)
    arena.reset(seed=seeds)
    few.reset(seed=seeds[-1:])
    for _ in range(6):
        actions = random_actions(config, size, source)
        arena.step(**actions)
        few.step(actions["choices"][-1:])

    assert arena.digest(size - 1) == few.digest(0)


@pytest.mark.parametrize(
    ("hunters", "targets", "seen"),
    [(1, 1, 1), pytest.param(64, 64, 64, marks=pytest.mark.large), (64, 1, 1), (1, 64, 9), (17, 33, 16)],
)
def test_any_number_of_hunters_and_targets_plays_alike(hunters, targets, seen):
    """R7.1's views of every width, from one arena and from a row of many."""
    config = BUSY.replace(
        hunters=hunters, max_targets=targets, initial_targets=targets, observed_targets=seen, control="full"
    )
    arena, source = VectorArena(config, 34), np.random.default_rng(SEED)
    observations, _ = arena.reset(seed=SEED)
    env = parallel_env(config)
    alone, _ = env.reset(seed=int(arena.seeds()[33]))
    for _ in range(8):
        assert (np.array(list(alone.values())) == observations[33]).all()
        actions = random_actions(config, 34, source)
        observations, *_ = arena.step(**actions)
        alone, *_ = env.step(one_arenas_actions(config, actions, 33))

    assert arena.digest(33) == env.digest()


@pytest.mark.rule("R4.4")
@pytest.mark.parametrize("size", [1, 40])
def test_r4_4_arenas_of_one_batch_may_differ_in_their_controls(size):
    """Each plays what a one-arena env of its controls plays; here some are changed on the way."""
    config, source = BUSY.replace(max_cycles=15), np.random.default_rng(SEED)
    arena = VectorArena(config, size, any_control=True)
    arena.reset(seed=SEED)
    controls = source.integers(0, 3, (size, 5))
    arena.set_controls(controls)
    rows = sorted({0, size // 3, size - 1})
    words = ("target", "velocity", "full")
    for _ in range(2):
        configs = {row: config.replace(control=tuple(words[c] for c in controls[row])) for row in rows}
        envs = {row: parallel_env(own) for row, own in configs.items()}
        for row, env in envs.items():
            env.reset(seed=int(arena.seeds()[row]))
        for _ in range(config.max_steps):
            actions = random_actions(config.replace(control="full"), size, source)
            for row, env in envs.items():
                results = env.step(one_arenas_actions(configs[row], actions, row))
            arena.step(**actions)
            if envs[0].agents:
                assert [arena.digest(row) for row in rows] == [env.digest() for env in envs.values()]
        assert (arena._infos["final_obs"][rows[-1]] == np.array(list(results[0].values()))).all()
        controls[rows] = source.integers(0, 3, (len(rows), 5))
        arena.set_controls(controls[rows], rows)


@pytest.mark.parametrize(
    ("controls", "arenas"),
    [([[0, 3]], [0]), ([[0, 0.5]], [0]), ([[0, 1]] * 2, [0]), ([[0], [0, 1]], None), ("target", None)],
)
def test_controls_that_cannot_be_are_refused(controls, arenas):
    """Any are refused if the arena was made without any_control."""
    arena = VectorArena("duel", 3, any_control=True)
    with pytest.raises(ConfigError, match="controls must be "):
        arena.set_controls(controls, arenas)
    with pytest.raises(ConfigError, match="make it with any_control=True"):
        VectorArena("duel", 3).set_controls([[0, 0]] * 3)


def test_controls_are_kept_with_a_state():
    """States of all arenas and of a single one have controls; an arena whose controls cannot differ takes no others."""
    arena = VectorArena("duel", 3, any_control=True)
    arena.reset(seed=SEED)
    arena.set_controls([[0, 1], [1, 2], [2, 0]])
    saved, row = arena.save(), arena.save(1)
    actions = {"commands": np.full((3, 2, 2), 0.5), "choices": np.ones((3, 2), int)}
    arena.step(**actions)
    expected = [arena.digest(number) for number in range(3)]
    for again in (arena, VectorArena("duel", 3, any_control=True)):
        again.reset(seed=1)
        again.set_controls([[1, 1], [0, 0], [1, 1]])
        again.restore(saved)
        again.step(**actions)
        assert [again.digest(number) for number in range(3)] == expected
        again.restore(row, 2)
        again.step(**actions)
        assert again.digest(2) == expected[1]
    plain = VectorArena("duel", 3)
    plain.reset(seed=1)
    for take in (lambda: plain.restore(saved), lambda: plain.restore(row, 0)):
        with pytest.raises(ConfigError, match="cannot differ in their controls: make it with any_control=True"):
            take()
    arena.restore(plain.save())
    assert (arena._engine.controls == 0).all()


@pytest.mark.parametrize("scenario", ["duel", "herd"])
def test_actions_can_be_checked_before_they_are_given(scenario):
    """`step` checks them in the same way, and nothing moves."""
    arena = VectorArena(scenario, 2)
    arena.reset(seed=SEED)
    before = arena.digest(0)
    good = np.ones((2, arena.num_hunters), int)
    bad = good.copy()
    bad[1, 1] = 99
    rest = np.zeros((2, arena.num_hunters + arena.num_prey, 2))
    assert arena.check_actions(good, rest) is None
    for give in (arena.check_actions, arena.step):
        with pytest.raises(ActionError, match=r"must be a whole number from 0 to 8, got 99 in arena 1 for hunter_1"):
            give(bad, rest)
    assert arena.digest(0) == before


@pytest.mark.large
@pytest.mark.parametrize("threads", [2, 3, 16])
def test_threads_do_not_change_anything(threads):
    """Also where there are more of them than cores; episodes end and begin meanwhile."""
    one, many = VectorArena(BUSY, 5000), VectorArena(BUSY, 5000, threads)
    one.reset(seed=SEED)
    many.reset(seed=SEED)
    source = np.random.default_rng(SEED)
    for _ in range(BUSY.max_steps + 3):
        actions = random_actions(BUSY, 5000, source)
        expected, got = one.step(**actions), many.step(**actions)
        for left, right in zip(expected[:4], got[:4], strict=True):
            assert (left == right).all()
    for left, right in zip(expected[4]["episode"].values(), got[4]["episode"].values(), strict=True):
        assert (left == right).all()

    assert one.save() == many.save()


def test_more_threads_than_there_is_work_for_cost_nothing():
    """Each has memory of its own, so that those which never play have none; and all arenas share them."""
    arena, other = VectorArena(BUSY, 2000, 4096), VectorArena(BUSY, 2000, 2)
    arena.reset(seed=SEED)
    other.reset(seed=SEED)
    hold = np.zeros((2000, 5), dtype=int)
    arena.step(hold)

    assert arena._engine.num_threads == 2
    before = set(threading.enumerate())  # some of them, from other tests, may end meanwhile
    other.step(hold)
    arena.close()
    arena.step(hold)
    assert set(threading.enumerate()) <= before
    assert repr(arena) == "<VectorArena: 2000 arenas, 5 hunters in each, target control>"


def test_arenas_that_step_at_the_same_time_share_the_threads():
    hold = np.zeros((2000, 5), dtype=int)

    def play(threads):
        arena = VectorArena(BUSY, 2000, threads)
        arena.reset(seed=SEED)
        for _ in range(20):
            arena.step(hold)
        return arena.digest(1999)

    with ThreadPoolExecutor(3) as pool:
        assert len(set(pool.map(play, (1, 2, 2)))) == 1


def step_in_a_child(arena, actions, queue):
    arena.step(actions)
    queue.put(arena.digest(4999))


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
def test_a_forked_process_plays_on_after_threads_have_played():
    """Threads do not live on in it, so that it must start its own."""
    arena = VectorArena(BUSY, 5000, 2)
    arena.reset(seed=SEED)
    actions = np.ones((5000, 5), dtype=np.int64)
    arena.step(actions)
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    child = context.Process(target=step_in_a_child, args=(arena, actions, queue))
    child.start()
    child.join(240)
    alive = child.is_alive()
    child.kill()
    arena.step(actions)

    assert not alive
    assert queue.get() == arena.digest(4999)


def test_arenas_that_have_ended_wait_for_their_reset_without_auto_reset():
    """Gymnasium's DISABLED mode: they stand still, and single ones are reset by number or by mask."""
    arena = VectorArena(BUSY, 33, auto_reset=False)
    arena.reset(seed=SEED)
    hold = np.zeros((33, 5), dtype=int)
    ends = [arena.step(hold)[3].tolist() for _ in range(BUSY.max_steps)]
    last = arena.digest(7)
    truncations = arena.step(hold)[3]
    ends += [truncations.tolist(), arena.step(hold)[3].tolist()]

    assert ends == [[False] * 33] * (BUSY.max_steps - 1) + [[True] * 33] * 3
    assert arena.digest(7) == last

    arena.reset(seed=[5, 6], arenas=[7, 32])
    assert truncations.all()  # of the last step, for a learner that looks at them after the reset
    arena.reset(arenas=np.arange(33) == 8)
    env = parallel_env(BUSY)
    env.reset(seed=6)

    assert arena.digest(32) == env.digest()
    assert arena.digest(0) != arena.digest(8)
    assert arena.world(8).step == 0


@pytest.mark.parametrize(
    "rows", [[], [0], [299], [31, 32], [200, 3, 64, 130, 129, 2, 299], range(300), range(299, -1, -1)]
)
def test_rows_that_are_reset_begin_with_their_own_seeds_and_the_others_go_on(rows):
    """In any order, in chunks side by side and far apart."""
    arena, other = VectorArena(BUSY, 300), VectorArena(BUSY, 300)
    arena.reset(seed=SEED)
    other.reset(seed=range(1000, 1300))
    for _ in range(3):
        arena.step(np.ones((300, 5), dtype=int))
    before, seen = arena.clone(), arena._engine.observations.copy()
    observations, _ = arena.reset(seed=[1000 + row for row in rows], arenas=rows)
    for row in range(300):
        expected = other if row in rows else before
        assert arena.digest(row) == expected.digest(row)
        assert (observations[row] == expected._engine.observations[row]).all()
    assert (before._engine.observations == seen).all()


@pytest.mark.parametrize("seed", [np.array(5), np.uint8(5), 5])
def test_any_whole_number_is_a_seed(seed):
    """NumPy's too, and an array without axes is one."""
    arena = VectorArena("duel", 3)
    arena.reset(seed=seed)

    assert arena.seeds().tolist() == batch_seeds(5, 3).tolist()


def test_what_restores_returns_what_a_reset_returns():
    """With copies there is no other way to the masks of what was restored."""
    arena = VectorArena("standard", 3, copy=True)
    first, infos = arena.reset(seed=SEED)
    saved, row = arena.save(), arena.save(2)
    for _ in range(30):
        last, *_ = arena.step(np.ones((3, 4), dtype=int))
    observations, notes = arena.restore(row, 2)

    assert (observations == np.stack((*last[:2], first[2]))).all()
    assert (notes["action_mask"][2] == infos["action_mask"][2]).all()
    observations, notes = arena.restore(saved)
    assert (observations == first).all()
    assert (notes["action_mask"] == infos["action_mask"]).all()


def test_episodes_without_a_seed_follow_one_another():
    """A.5: a run is repeated by its first seed alone."""
    runs = []
    for _ in range(2):
        arena = VectorArena("duel", 9)
        arena.reset(seed=SEED)
        arena.reset()
        arena.reset(arenas=[3])
        runs.append(arena.seeds().tolist())

    assert runs[0] == runs[1]
    assert len({*runs[0], *batch_seeds(SEED, 9).tolist()}) == 18
    assert VectorArena("duel", 2).reset()[0].shape == (2, 2, *VectorArena("duel").observation_space().shape)


@pytest.mark.large
def test_a_step_allocates_nothing():
    """But a few small objects of Python's and NumPy's buffer for a conversion: less than one flag for each arena."""
    arena = VectorArena("standard", 20_000)
    arena.reset(seed=SEED)
    actions = np.ones((20_000, 4), dtype=np.int64)
    arena.step(actions)
    tracemalloc.start()
    try:
        for _ in range(5):
            arena.step(actions)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()

    assert peak < 20_000


def test_buffers_are_reused_unless_copies_are_asked_for():
    """The mask, of which only changes are written, is read only."""
    for copied in (False, True):
        arena = VectorArena("standard", 3, copy=copied)
        first, infos = arena.reset(seed=SEED)
        kept = first.copy()
        second = arena.step(np.ones((3, 4), dtype=np.int64))[0]

        assert (second is first) != copied
        assert (first == kept).all() == copied
        assert infos["action_mask"].flags.writeable == copied


NAN = np.zeros((2, 2, 2))
NAN[1, 0, 1] = np.nan
ILLEGAL = [
    ("target", [[[1, 2, 3]]], "choices must be whole numbers of the shape (2, 2), got [[1, 2, 3]]"),
    ("target", [[[0, 1], [9, 0]]], "choices must be a whole number from 0 to 8, got 9 in arena 1 for hunter_0"),
    ("target", [[[0.0, 1.0], [0.0, 1.0]]], "choices must be whole numbers of the shape (2, 2), got [[0.0, 1.0], ["),
    ("target", [{"hunter": 1}], "choices must be whole numbers of the shape (2, 2), got {'hunter': 1}"),
    ("target", [[[1, 2], [1]]], "choices must be whole numbers of the shape (2, 2), got [[1, 2], [1]]"),
    ("target", [], "choices must be whole numbers of the shape (2, 2), got None"),
    ("target", [[[0, 1], [0, 1]], NAN], "commands must be two finite numbers, got [0.0, nan]"),
    ("velocity", [None, NAN], "commands must be two finite numbers, got [0.0, nan] in arena 1 for hunter_0"),
    (
        "velocity",
        [None, np.ones((2, 2, 2), dtype=bool)],
        "commands must be numbers of the shape (2, 2, 2), got an array of bool",
    ),
    ("velocity", [], "commands must be numbers of the shape (2, 2, 2), got None"),
    ("full", [None, np.zeros((2, 2, 2))], "choices must be whole numbers of the shape (2, 2), got None"),
    ("full", [[[0, 0], [0, 0]]], "commands must be numbers of the shape (2, 2, 2), got None"),
]


@pytest.mark.parametrize(("control", "actions", "message"), ILLEGAL)
def test_an_illegal_action_moves_nothing(control, actions, message):
    """The error names the arena and the hunter."""
    arena = VectorArena("duel", 2, control=control)
    arena.reset(seed=1)
    before = arena.digest(1)
    with pytest.raises(ActionError, match=re.escape(message)):
        arena.step(*actions)

    assert arena.digest(1) == before


def test_what_else_is_wrong_is_told_in_one_line():
    """Sizes, rows, states of other shapes, and play before the first reset."""
    for size in (0, 2.0, 10**30):
        with pytest.raises(ConfigError, match="num_envs must be a whole number from 1 to 1000000000, got"):
            VectorArena("duel", size)
    with pytest.raises(ConfigError, match="num_threads must be a whole number from 1 to 4096, got True"):
        VectorArena("duel", 1, num_threads=True)
    with pytest.raises(ConfigError, match="unknown scenario"):
        VectorArena("dual", 1)
    arena = VectorArena("duel", 3)
    for name, call in {
        "step": lambda: arena.step([[0, 0]] * 3),
        "digest": lambda: arena.digest(0),
        "restore": lambda: arena.restore(None, 1),
        "save": arena.save,
        "seeds": arena.seeds,
    }.items():
        with pytest.raises(EpisodeError, match=rf"^cannot call {name}\(\): no episode has begun"):
            call()
    with pytest.raises(EpisodeError, match=r"^cannot reset single arenas: no episode has begun; call reset\(\)"):
        arena.reset(arenas=[1])
    arena.reset(seed=1)
    with pytest.raises(ConfigError, match="arena must be a whole number from 0 to 2, got 3"):
        arena.digest(3)
    with pytest.raises(ConfigError, match="arenas must be different rows from 0 to 2, or a mask of 3, got"):
        arena.reset(arenas=[3])
    with pytest.raises(
        ConfigError, match=r"arenas must be different rows from 0 to 2, or a mask of 3, got \[2, 1, 1\]"
    ):
        arena.reset(seed=5, arenas=[2, 1, 1])
    with pytest.raises(ConfigError, match="seeds must be one for each of 3 arenas, got 2"):
        arena.reset(seed=[1, 2])
    other, larger = VectorArena("duel", 3, reach_m=0.2), VectorArena("duel", 40)
    other.reset(seed=1)
    larger.reset(seed=1)
    for restore, saved, message in (
        (arena.restore, other.save(), "saved must come from an arena with an equal config"),
        (arena.restore, None, r"saved must be a state that a batch's save\(\) returned"),
        (arena.restore, larger.save(), "a saved state must be that of 3 arenas here, got that of 40 arenas"),
        (arena.restore, arena.save(0), "a saved state must be that of 3 arenas here, got that of a single row"),
        (lambda saved: arena.restore(saved, 0), larger.save(), "must be that of a single row here, got that of 40"),
    ):
        with pytest.raises(ConfigError, match=message):
            restore(saved)
    for seed in (-1, 5.0, "123", True, [[1]] * 3):
        with pytest.raises(ConfigError, match="seed must be a whole number"):
            arena.reset(seed=seed)
    with pytest.raises(ConfigError, match="auto_reset must be true or false, got 'no'"):
        VectorArena("duel", 1, auto_reset="no")


def test_the_spaces_are_those_of_the_one_arena_env():
    """By seat; the mask is among the infos in any case."""
    arena = VectorArena("duel", 2, control=("target", "full"), mask_in_observation=True)
    env = parallel_env("duel", control=("target", "full"))
    for seat in range(2):
        assert arena.observation_space(seat) == env.observation_space(f"hunter_{seat}")
        assert arena.action_space(seat) == env.action_space(f"hunter_{seat}")
