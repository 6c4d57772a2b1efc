"""examples/train_ppo.py, imitate.py and train_sb3.py: short runs, what they leave, and what goes wrong."""

import importlib.util
import json
import subprocess
import sys
import time
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from training_runs import (
    ROOT,
    SHORT,
    begun,
    check,
    interrupted,
    output_of,
    refused,
    refused_here,
    run,
    table,
    train,
    trainer,
)

from catch_arena import scenario
from catch_arena.agents.patrol import Agent as Patrol
from catch_arena.batch_policy import BatchView
from catch_arena.layout import columns
from catch_arena.policy import Limits
from catch_arena.tournament.loading import create_policy
from catch_arena.training import LearnerBatch
from catch_arena.training.pointer import PointerAgent, PointerNetwork, weight_shapes


@pytest.fixture(scope="module")
def module():
    """examples/train_ppo.py."""
    spec = importlib.util.spec_from_file_location("train_ppo", ROOT / "examples/train_ppo.py")
    made = importlib.util.module_from_spec(spec)
    sys.modules["train_ppo"] = made
    spec.loader.exec_module(made)
    return made


@pytest.mark.parametrize("script", ["examples/train_ppo.py", "examples/train_sb3.py"])
def test_without_torch_a_line_says_what_to_install(script):
    code = (
        "import runpy, sys; sys.modules['torch'] = sys.modules['sb3_contrib'] = None; "
        f"runpy.run_path({str(ROOT / script)!r}, run_name='__main__')"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert len(done.stderr.splitlines()) == 1
    assert "is not installed: pip install '.[" in done.stderr


CURVE = """decisions,seconds,agent,matches,rating,rating_low,rating_high,win_share,win_share_low,win_share_high
{first},60,ppo,60,{rating},0,0,{share},0,1
{first},60,patrol,60,130,0,0,0.3,0,1
{first},60,nearest,60,-90,0,0,0.1,0,1
"""


def evaluation(side, against, decisions, **figures):
    """A row of a curve.json."""
    return {"side": side, "against": against, "decisions": decisions, "seconds": 7, **figures}


def test_curves_of_sides_have_a_table_and_a_panel_for_each_opponent(tmp_path):
    """A column and a line for each seed; catches of prey are those of the script."""
    for name, catches in (("one", 4.0), ("two", 6.0)):
        curve = [
            evaluation("hunters", "flee", 0, catches=[0.1, -0.1, 0.3]),
            evaluation("prey", "intercept", 0, catches=[19, 18, 20]),
            evaluation("hunters", "flee", 2_000_000 + 200_000 * catches, catches=[catches, catches - 1, catches + 1]),
        ]
        if name == "two":  # this one has got further
            curve.append(evaluation("hunters", "flee", 4_000_000, catches=[8, 8, 8]))
        (tmp_path / name).mkdir()
        found = {"settings": {"scenario": "tag", "seed": 1}, "curve": curve}
        (tmp_path / name / "curve.json").write_text(json.dumps(found))
    runs = [tmp_path / "one", tmp_path / "two"]
    printed = run("examples/training_curves.py", *runs, "--out", tmp_path / "curve.svg").splitlines()
    assert printed[:6] == [
        "",
        "catches of hunters against flee in tag:",
        "",
        "| decisions | one | two |",
        "|---:|---:|---:|",
        "| 0 thousand | 0.1 (0.0 to 0.3) | 0.1 (0.0 to 0.3) |",
    ]
    assert printed[6] == "| 3.0 million | 4.0 (3.0 to 5.0) | 6.0 (5.0 to 7.0) |"
    assert printed[8] == "catches of intercept against prey in tag:"
    assert printed[12:] == [
        "| 0 thousand | 19.0 (18.0 to 20.0) | 19.0 (18.0 to 20.0) |",
        f"curve: {tmp_path / 'curve.svg'}",
    ]
    drawn = ET.parse(tmp_path / "curve.svg").getroot()  # noqa: S314 - ours
    assert drawn.get("viewBox") == "0 0 640 660"
    lines = [path.get("d") for path in drawn.findall("{*}path") if path.get("fill") == "none"]
    # the axes end at 4 million decisions and at 8 catches
    assert lines[:2] == ["M60.0 277.0L452.0 160.0", "M60.0 277.0L508.0 100.0L620.0 40.0"]
    assert len(lines) == 4
    titles = [text.text for text in drawn.findall("{*}text") if text.get("font-weight") and text.text]
    assert titles == ["catches of hunters against flee in tag", "catches of intercept against prey in tag"]


def test_shares_of_wins_are_in_percent(tmp_path):
    curve = [evaluation("seat", "nearest", 1_000_000, wins=[0.5, 0.4, 0.6], catches=[3, 2, 4])]
    found = {"settings": {"scenario": "standard"}, "curve": curve}
    (tmp_path / "curve.json").write_text(json.dumps(found))
    printed = run("examples/training_curves.py", tmp_path).splitlines()
    assert printed[1] == "share of wins of seat against nearest in standard:"
    assert printed[-1] == "| 1.0 million | 50 % (40 to 60) |"
    assert run("examples/training_curves.py", tmp_path, tmp_path / "gone", fails=True) == (
        f"{tmp_path / 'gone'}: has no curve.json; a trainer writes it after --evaluate decisions\n"
    )


def test_curves_of_several_seeds_are_one_table(tmp_path):
    """The mean, the least and the most; the lead is that over the best of the others."""
    for name, rating, share in (("a", 190, 0.5), ("b", 100, 0.4), ("c", 220, 0.75)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "curve.csv").write_text(CURVE.format(first=507904, rating=rating, share=share))
    *_, row = run("examples/training_curves.py", *(tmp_path / name for name in "abc")).splitlines()
    assert row == "| 508 thousand | 60 | 55 % | 40 to 75 % | +40 (-30 to +90) |"
    later = CURVE.format(first=1015808, rating=0, share=0.1).partition("\n")[2]
    with (tmp_path / "a" / "curve.csv").open("a") as file:
        file.write(later)  # the others have not got so far
    assert run("examples/training_curves.py", *(tmp_path / name for name in "abc")).splitlines()[-1] == row
    (tmp_path / "c" / "curve.csv").write_text(CURVE.partition("\n")[0] + "\n" + later)
    assert "no tournament after the same number" in run(
        "examples/training_curves.py", tmp_path / "b", tmp_path / "c", fails=True
    )
    run("examples/training_curves.py", tmp_path / "a", tmp_path / "b", "--out", tmp_path / "curve.svg")
    paths = ET.parse(tmp_path / "curve.svg").findall("{*}path")  # noqa: S314 - ours
    assert paths[-1].get("d") == "M620.0 172.0"  # the mean of 50 and 40 %


@pytest.mark.torch
@pytest.mark.parametrize(
    ("head", "opponents"),
    [
        ("destination", "triage,nearest"),
        pytest.param("velocity", "patrol", marks=pytest.mark.nightly),
        pytest.param("rank", "contested", marks=pytest.mark.nightly),
    ],
)
def test_a_short_run_leaves_an_agent_that_plays(tmp_path, head, opponents):
    out = tmp_path / "run"
    printed = train(
        "--out", out, "--head", head, "--opponents", opponents, "--decisions", 400,
        *SHORT, "--evaluate", 256, "--evaluate-rounds", 1,
    )  # fmt: skip
    assert "agent.py" in printed
    rows = table(out / "curve.csv")
    assert {row["agent"] for row in rows} == {"ppo", "patrol", "contested_by_time", "contested"}
    assert all(float(row["seconds"]) > 0 for row in rows)
    progress = table(out / "progress.csv")
    assert [int(row["decisions"]) for row in progress] == [128, 256, 384, 512]
    assert all(np.isfinite(float(row["value_error"])) for row in progress)
    assert all(0 <= float(row["wins"]) <= 1 for row in progress)
    check(out / "agent.py")
    network = PointerNetwork.load(out / "agent.npz")
    assert network.head == head
    assert network.weights["mix"].shape == (8, 8)


@pytest.mark.torch
def test_a_network_that_copies_an_agent_comes_nearer_to_it_and_can_be_trained(tmp_path):
    batch, teacher, errors = LearnerBatch("standard", 64, opponents="nearest", control="velocity"), Patrol(), {}
    teacher.reset(1)
    observations, masks = batch.reset(seed=1)
    view = BatchView(observations, masks, Limits.of(batch.config))
    for decisions in (8, 8000):
        out = tmp_path / str(decisions)
        output_of(trainer("patrol", "--out", out, *SHORT, module="imitate", DECISIONS=decisions))
        answers = PointerAgent(out / "agent.npz").act_batch(view)
        errors[decisions] = np.square(answers - teacher.act_batch(view)).mean()
    assert errors[8000] < 0.7 * errors[8]
    check(out / "agent.py")
    start = ["--head", "velocity", "--start", out / "agent.npz", "--opponents", "nearest"]
    train("--out", tmp_path / "run", *start, *SHORT, "--decisions", 128)
    check(tmp_path / "run" / "agent.py")


@pytest.mark.torch
@pytest.mark.parametrize("agent", ["contested", "random"])
def test_an_agent_that_cannot_be_copied_is_one_line(tmp_path, agent):
    printed = output_of(trainer(agent, *SHORT, "--out", tmp_path / "copy", module="imitate"), fails=True)
    assert printed == f"imitate: agent must have act_batch and velocity control, got {agent}\n"


@pytest.mark.torch
def test_the_same_seed_learns_the_same_and_a_run_goes_on_where_it_was(tmp_path):
    for name in ("one", "other"):
        train("--out", tmp_path / name, "--opponents", "nearest", "--decisions", 256, *SHORT)
    one, other = (PointerNetwork.load(tmp_path / name / "agent.npz").weights for name in ("one", "other"))
    for name, weights in one.items():
        np.testing.assert_array_equal(weights, other[name])
    again = ["--out", tmp_path / "one", "--opponents", "nearest", *SHORT]
    assert "or give --resume" in refused(*again)
    train(*again, "--decisions", 512, "--resume")
    decisions = [int(row["decisions"]) for row in table(tmp_path / "one" / "progress.csv")]
    assert decisions == [128, 256, 384, 512]
    later = PointerNetwork.load(tmp_path / "one" / "agent.npz").weights
    assert any((later[name] != weights).any() for name, weights in one.items())
    seconds = [float(row["seconds"]) for row in table(tmp_path / "one" / "progress.csv")]
    assert seconds == sorted(seconds)
    assert "--hold must be 2, as in the saved run; leave it out" in refused(*again, "--resume", "--hold", 3)
    assert "check-agent" in train("--out", tmp_path / "one", "--resume")  # nothing is left to do
    assert "No such file" in refused("--out", tmp_path / "new", "--opponents", "nearest", *SHORT, "--resume")


@pytest.mark.torch
def test_a_state_of_another_version_is_refused(tmp_path):
    import torch

    out = tmp_path / "run"
    train("--out", out, "--opponents", "nearest", "--decisions", 256, *SHORT)
    state = torch.load(out / "state.pt", weights_only=True)
    torch.save(state | {"version": "catch_arena_v0"}, out / "state.pt")
    printed = refused("--out", out, "--resume", "--decisions", 512)
    assert printed.endswith("state.pt is of another version; begin a new run")
    torch.save(state, out / "state.pt")
    (out / "progress.csv").write_text("")  # a disk was full; the rows are in the state
    train("--out", out, "--resume", "--decisions", 384)
    assert [int(row["decisions"]) for row in table(out / "progress.csv")] == [128, 256, 384]


@pytest.mark.torch
def test_a_run_goes_on_with_the_settings_that_it_began_with(tmp_path):
    """The prior is that of the network it started from, whose file need not be there any more."""
    first, second = tmp_path / "first", tmp_path / "second"
    short = ["--opponents", "nearest", *SHORT]
    train("--out", first, "--decisions", 128, "--prior", 1.5, *short)
    train("--out", second, "--decisions", 128, "--start", first / "agent.npz", *short)
    (first / "agent.npz").unlink()
    train("--out", second, "--decisions", 256, "--resume")
    assert [int(row["decisions"]) for row in table(second / "progress.csv")] == [128, 256]
    assert PointerNetwork.load(second / "agent.npz").weights["prior"] == 1.5


@pytest.mark.torch
@pytest.mark.parametrize("when", ["decisions, ", pytest.param("playing a tournament", marks=pytest.mark.nightly)])
def test_ctrl_c_keeps_the_run_and_the_agent(tmp_path, when):
    """In the loop, and in the last tournament."""
    out = tmp_path / "run"
    decisions, every = (10**9, 0) if when == "decisions, " else (512, 512)
    process = begun(
        "--out", out, "--opponents", "nearest", *SHORT, "--decisions", decisions,
        "--evaluate", every, "--evaluate-rounds", 500, SNAPSHOT=10**9,
    )  # fmt: skip
    lines = (line for line in process.stdout if when in line)
    for _ in range(2 if when == "decisions, " else 1):  # the line of an update comes before its run is saved
        next(lines)
    output = interrupted(process)
    assert output[-1] == "catch-arena: interrupted: each finished update is kept; --resume continues"
    assert not [line for line in output if "Traceback" in line]
    made = int(table(out / "progress.csv")[-1]["decisions"])
    assert PointerNetwork.load(out / "agent.npz").head == "destination"
    more = ["--decisions", made + 128, "--evaluate", every, "--evaluate-rounds", 1]
    train("--out", out, "--resume", *more, AGAINST=("nearest", "first", "idle"))
    assert int(table(out / "progress.csv")[-1]["decisions"]) == made + 128
    if every:  # the tournament that was broken off is played again
        assert [row["decisions"] for row in table(out / "curve.csv")] == 4 * ["512"]


@pytest.mark.torch
def test_ctrl_c_before_anything_is_learned_is_one_line(tmp_path):
    process = begun("--out", tmp_path / "run", "--opponents", "nearest", *SHORT)
    time.sleep(0.5)  # it imports torch
    output = interrupted(process)
    assert output[-1].startswith("catch-arena: interrupted")
    assert not [line for line in output if "Traceback" in line]


@pytest.mark.torch
def test_the_help_says_what_each_setting_means():
    output = " ".join(train("--help").split())
    assert "--hold HOLD number of steps for which a decision holds (default: 2)" in output


@pytest.mark.torch
def test_a_run_that_is_killed_leaves_an_agent_and_goes_on(tmp_path):
    out = tmp_path / "run"
    more = ["--out", out, "--opponents", "nearest", *SHORT]
    with subprocess.Popen(
        trainer(*more, "--decisions", 10**9), stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT
    ) as process:
        late = time.monotonic() + 300
        while not (out / "state.pt").exists() and process.poll() is None and time.monotonic() < late:
            time.sleep(0.1)
        process.kill()
    assert PointerNetwork.load(out / "agent.npz").head == "destination"
    before = len(table(out / "progress.csv"))
    train(*more, "--decisions", 128 * (before + 1), "--resume")
    made = [int(row["decisions"]) for row in table(out / "progress.csv")]
    assert made == [128 * (place + 1) for place in range(before + 1)]


@pytest.mark.torch
@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        ("--head tail", "argument --head: invalid choice: 'tail'"),
        ("--hold 0", "--hold must be at least 1, got 0"),
        ("--scenario unequal", "--scenario must have equal hunters and no prey, got unequal"),
        ("--scenario tag", "--scenario must have equal hunters and no prey, got tag"),
        ("--scenario moon", "moon"),
        ("--opponents nobody", "nobody"),
        ("--start gone.npz", "gone.npz"),
        ("--start other.npz --hidden 16", "--hidden must be 8, as in --start, got 16"),
        ("--prior inf", "not finite; lower RATE"),
        ("--opponents nearest,", "an agent must be a name, a file, a folder or a command"),
    ],
)
def test_bad_options_are_one_line(module, tmp_path, arguments, error, monkeypatch, capsys):
    short = [*SHORT, "--out", tmp_path / "run", "--decisions", 512]
    opponents = [] if "--opponents" in arguments else ["--opponents", "nearest"]
    network = tmp_path / "other.npz"
    weights = {name: np.zeros(shape) for name, shape in weight_shapes("destination", 8).items()}
    PointerNetwork("destination", weights).save(network)
    given = [*short, *opponents, *arguments.replace("other.npz", str(network)).split()]
    assert error in refused_here(module, given, monkeypatch, capsys)


@pytest.mark.torch
@pytest.mark.parametrize("head", ["destination", "velocity"])
def test_the_network_decides_the_same_in_torch_and_in_numpy(module, head, monkeypatch):
    import torch

    torch.manual_seed(1)
    monkeypatch.setattr(module, "ARENAS", 8)
    settings, _ = module.settings_from(["--head", head, "--hidden", "16", "--opponents", "nearest", "--seed", "2"])
    trained = module.Network(head, settings.hidden, settings.prior)
    with torch.no_grad():
        for weights in trained.weights.values():
            weights.normal_(0, 0.3)
    arenas = module.Arenas(settings)
    looked = module.destinations(arenas.view)
    chances, mean, _ = trained(*module.tensors(looked))
    network = trained.agent().network
    logits, mixed = network(looked)
    ours = logits - np.log(np.exp(logits.astype(np.float64)).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(chances.detach().numpy()[looked.legal], ours[looked.legal], atol=1e-4)
    if head == "velocity":
        np.testing.assert_allclose(mean.detach().numpy(), network.velocities(logits, mixed), atol=1e-4)


@pytest.mark.torch
def test_advantages_are_the_sums_of_discounted_errors(module, monkeypatch):
    """By the definition, in place of the recursion."""
    import torch

    monkeypatch.setattr(module, "LAMBDA", 0.8)
    torch.manual_seed(2)
    values, gained, following = torch.randn(6, 3), torch.randn(6, 3), torch.randn(3)
    ended = (torch.rand(6, 3) < 0.3).float()
    gamma = 0.9**2
    found = module.advantages_of(gained, ended, values, following, gamma)
    later = torch.cat((values[1:], following[None]))
    errors = gained + gamma * (1 - ended) * later - values
    for moment in range(6):
        for row in range(3):
            wanted, weight = 0.0, 1.0
            for step in range(moment, 6):
                wanted += weight * float(errors[step, row])
                if ended[step, row]:
                    break
                weight *= gamma * 0.8
            assert float(found[moment, row]) == pytest.approx(wanted, abs=1e-5)


@pytest.mark.torch
def test_past_selves_that_win_are_met_more_often(module, monkeypatch):
    monkeypatch.setattr(module, "ARENAS", 4)
    monkeypatch.setattr(module, "MOST_SELVES", 2)
    options = "--scenario duel --opponents nearest,idle --self-play 0.5 --hidden 8"
    settings, _ = module.settings_from(options.split())
    arenas = module.Arenas(settings)
    pool = arenas.pool
    network = module.Network(settings.head, settings.hidden, settings.prior)
    for _ in range(3):
        pool.grow(network.agent())
    assert pool.alive.sum() == 2 + 2
    pool.beaten[:] = (0.1, 0.9, 0.5, 0.2, 0.9)
    pool.alive[:] = True
    pool.weigh()
    weights = arenas.batch.opponents.weights
    assert weights[:2].sum() == pytest.approx(0.5)
    assert weights[0] > weights[1]
    assert weights[3] > weights[2] > weights[4]


@pytest.mark.torch
@pytest.mark.parametrize(
    ("name", "control"),
    [
        ("pack", "velocity"),
        pytest.param("duel", "target", marks=pytest.mark.nightly),
        pytest.param("partners", "target", marks=pytest.mark.nightly),
    ],
)
def test_the_short_example_leaves_an_agent_that_plays(tmp_path, name, control):
    output = run("examples/train_sb3.py", "--out", tmp_path / "sb3", "--scenario", name, "--steps", 8192)
    assert "check-agent" in output
    made = create_policy(str(tmp_path / "sb3" / "agent.py"))
    assert made.network.inputs == len(columns(scenario(name)))
    assert made.control == control
    check(tmp_path / "sb3" / "agent.py", name)


@pytest.mark.torch
@pytest.mark.parametrize(
    ("options", "error"),
    [
        ("--prey-agent flee", "prey_agent must be None in a scenario without prey, got flee"),
        ("--scenario tag --prey-agent nobody", "nobody"),
        ("--scenario moon", "unknown scenario 'moon'"),
        ("--steps 0", "--steps must be at least 1, got 0"),
    ],
)
def test_what_stable_baselines3_cannot_learn_is_one_line(tmp_path, options, error):
    output = run("examples/train_sb3.py", "--out", tmp_path / "sb3", *options.split(), fails=True)
    assert output.startswith("train_sb3: ")
    assert error in output
    assert len(output.splitlines()) == 1
