"""examples/train_ppo.py and examples/train_sb3.py: short runs, what they leave, and what goes wrong."""

import csv
import importlib.util
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from catch_arena.tournament.loading import create_policy
from catch_arena.training.pointer import PointerNetwork, weight_shapes

ROOT = Path(__file__).parents[2]
SHORT = ("--arenas=8", "--horizon=16", "--minibatch=64", "--hidden=8", "--snapshot=128", "--evaluate=0", "--seed=3")


def run(script, *arguments, fails=False):
    """What a script says, on both channels."""
    command = [sys.executable, ROOT / script, *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode != 0) == fails, done.stdout + done.stderr
    return done.stdout + done.stderr


def table(path):
    """The rows of a CSV file."""
    with path.open() as file:
        return list(csv.DictReader(file))


def refused(*arguments):
    """The one line that says why."""
    said = [
        line for line in run("examples/train_ppo.py", *arguments, fails=True).splitlines() if "compiling" not in line
    ]
    said = [line for line in said if " decisions, " not in line]
    assert len(said) == 1, said
    assert said[0].startswith("train_ppo: ")
    return said[0]


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
    assert "which is not installed: pip install '.[" in done.stderr


CURVE = """decisions,seconds,agent,matches,rating,rating_low,rating_high,win_share,win_share_low,win_share_high
{first},60,ppo,60,{rating},0,0,{share},0,1
{first},60,patrol,60,130,0,0,0.3,0,1
{first},60,nearest,60,-90,0,0,0.1,0,1
"""


def test_curves_of_several_seeds_are_one_table(tmp_path):
    """The mean, the least and the most; the lead is that over the best of the others."""
    for name, rating, share in (("a", 190, 0.5), ("b", 100, 0.4), ("c", 220, 0.75)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "curve.csv").write_text(CURVE.format(first=507904, rating=rating, share=share))
    *_, row = run("examples/training_curves.py", *(tmp_path / name for name in "abc")).splitlines()
    assert row == "| 0.5 million | 60 | 55 % | 40 to 75 % | +40 (-30 to +90) |"
    later = CURVE.format(first=1015808, rating=0, share=0.1).partition("\n")[2]
    with (tmp_path / "a" / "curve.csv").open("a") as file:
        file.write(later)  # the others have not got so far
    assert run("examples/training_curves.py", *(tmp_path / name for name in "abc")).splitlines()[-1] == row
    (tmp_path / "c" / "curve.csv").write_text(CURVE.partition("\n")[0] + "\n" + later)
    assert "no tournament after the same number" in run(
        "examples/training_curves.py", tmp_path / "b", tmp_path / "c", fails=True
    )
    (tmp_path / "c" / "curve.csv").write_text("decisions,agent\n1,ppo\n")
    said = run("examples/training_curves.py", tmp_path / "c", fails=True)
    assert "must be a curve that train_ppo.py has written" in said
    assert len(said.splitlines()) == 1


@pytest.mark.torch
@pytest.mark.parametrize(
    ("head", "opponents"), [("destination", "triage,nearest"), ("rank", "contested"), ("velocity", "patrol")]
)
def test_a_short_run_leaves_an_agent_that_plays(tmp_path, head, opponents):
    out = tmp_path / "run"
    copy = ["--imitate", opponents, "--imitate-decisions", 400] if head != "destination" else []
    said = run(
        "examples/train_ppo.py", "--out", out, "--head", head, "--opponents", opponents, "--decisions", 400,
        *copy, *SHORT, "--evaluate", 256, "--evaluate-rounds", 1,
    )  # fmt: skip
    assert "agent.py" in said
    rows = table(out / "curve.csv")
    assert {row["agent"] for row in rows} == {"ppo", "patrol", "contested_by_time", "contested"}
    assert all(float(row["seconds"]) > 0 for row in rows)
    progress = table(out / "progress.csv")
    assert [int(row["decisions"]) for row in progress] == [128, 256, 384, 512]
    assert all(np.isfinite(float(row["value_error"])) for row in progress)
    check = [sys.executable, "-m", "catch_arena", "check-agent", str(out / "agent.py"), "--scenario", "duel"]
    assert "ok" in subprocess.run(check, capture_output=True, text=True, check=True, cwd=ROOT).stdout
    network = PointerNetwork.load(out / "agent.npz")
    assert network.head == head
    assert network.weights["mix"].shape == (8, 8)


@pytest.mark.torch
def test_the_same_seed_learns_the_same_and_a_run_goes_on_where_it_was(tmp_path):
    for name in ("one", "other"):
        run("examples/train_ppo.py", "--out", tmp_path / name, "--opponents", "nearest", "--decisions", 256, *SHORT)
    one, other = (PointerNetwork.load(tmp_path / name / "agent.npz").weights for name in ("one", "other"))
    for name, weights in one.items():
        np.testing.assert_array_equal(weights, other[name])
    again = ["--out", tmp_path / "one", "--opponents", "nearest", *SHORT]
    assert "or give --resume" in refused(*again)
    run("examples/train_ppo.py", *again, "--decisions", 512, "--resume")
    decisions = [int(row["decisions"]) for row in table(tmp_path / "one" / "progress.csv")]
    assert decisions == [128, 256, 384, 512]
    later = PointerNetwork.load(tmp_path / "one" / "agent.npz").weights
    assert any((later[name] != weights).any() for name, weights in one.items())
    seconds = [float(row["seconds"]) for row in table(tmp_path / "one" / "progress.csv")]
    assert seconds == sorted(seconds)
    assert "--gamma must be 0.985, as the run began, got 0.5" in refused(*again, "--resume", "--gamma", 0.5)
    assert "--decisions must be above the 512 that the run has made" in refused("--out", tmp_path / "one", "--resume")
    assert "there is no" in refused("--out", tmp_path / "new", "--opponents", "nearest", *SHORT, "--resume")


class RunsCode:
    """What a pickle can do."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.torch
def test_a_state_that_is_damaged_or_of_another_kind_is_refused_and_runs_no_code(tmp_path):
    import torch

    out = tmp_path / "run"
    run("examples/train_ppo.py", "--out", out, "--opponents", "nearest", "--decisions", 256, *SHORT)
    state = torch.load(out / "state.pt", weights_only=True)
    whole, mark = (out / "state.pt").read_bytes(), tmp_path / "mark"
    for changed in (
        b"nothing",
        whole[: len(whole) // 2],
        {name: value for name, value in state.items() if name != "version"},
        state | {"version": ["catch_arena_v0", *state["version"][1:]]},
        state | {"version": state["version"][:-1]},
        state | {"more": RunsCode(mark)},
    ):
        if isinstance(changed, bytes):
            (out / "state.pt").write_bytes(changed)
        else:
            torch.save(changed, out / "state.pt")
        said = refused("--out", out, "--resume", "--decisions", 512)
        assert "must be the state of a run of this version, and complete: begin a new run" in said
    assert not mark.exists()
    (out / "state.pt").write_bytes(whole)
    (out / "progress.csv").write_text("")  # what a full disk leaves
    run("examples/train_ppo.py", "--out", out, "--resume", "--decisions", 384)
    assert [int(row["decisions"]) for row in table(out / "progress.csv")] == [384]


@pytest.mark.torch
def test_a_run_goes_on_with_the_settings_that_it_began_with(tmp_path):
    """The prior is that of the network it started from, whose file need not be there any more."""
    first, second = tmp_path / "first", tmp_path / "second"
    short = ["--opponents", "nearest", *SHORT]
    run("examples/train_ppo.py", "--out", first, "--decisions", 128, "--prior", 1.5, *short)
    run("examples/train_ppo.py", "--out", second, "--decisions", 128, "--start", first / "agent.npz", *short)
    (first / "agent.npz").unlink()
    run("examples/train_ppo.py", "--out", second, "--decisions", 256, "--resume")
    assert [int(row["decisions"]) for row in table(second / "progress.csv")] == [128, 256]
    assert PointerNetwork.load(second / "agent.npz").weights["prior"] == 1.5


def begun(*arguments):
    """train_ppo.py as a process of its own, whose lines can be read."""
    command = [sys.executable, ROOT / "examples" / "train_ppo.py", *arguments]
    return subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )


def interrupted(process):
    """What it says after a Ctrl-C."""
    os.killpg(process.pid, signal.SIGINT)
    said = process.communicate(timeout=120)[0].splitlines()
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)  # nothing of it is left
    return said


@pytest.mark.torch
@pytest.mark.parametrize("when", ["decisions, ", "playing a tournament"])
def test_ctrl_c_keeps_the_run_and_the_agent(tmp_path, when):
    """In the loop, and in the last tournament."""
    out = tmp_path / "run"
    decisions, every = (10**9, 0) if when == "decisions, " else (512, 512)
    process = begun(
        "--out", out, "--opponents", "nearest", *SHORT, "--snapshot", 10**9, "--decisions", decisions,
        "--evaluate", every, "--evaluate-rounds", 500,
    )  # fmt: skip
    for line in process.stdout:
        if when in line:
            break
    said = interrupted(process)
    assert said[-1].startswith("catch-arena: interrupted: after ")
    assert said[-1].endswith("decisions; --resume goes on")
    assert not [line for line in said if "Traceback" in line]
    made = int(said[-1].split()[3].replace(",", ""))
    assert made == int(table(out / "progress.csv")[-1]["decisions"])
    assert PointerNetwork.load(out / "agent.npz").head == "destination"
    shorter = ["--evaluate", every, "--evaluate-rounds", 1, "--evaluate-against", "nearest,first,idle"]
    said = run("examples/train_ppo.py", "--out", out, "--resume", "--decisions", made + 128, *shorter)
    assert int(table(out / "progress.csv")[-1]["decisions"]) == made + 128
    if every:  # the tournament that was broken off is played again
        assert [row["decisions"] for row in table(out / "curve.csv")] == 4 * ["512"]
        assert re.search(r"tournament after 512 decisions\nrating .*, wins .* %\n", said)


@pytest.mark.torch
def test_ctrl_c_before_anything_is_learned_is_one_line(tmp_path):
    process = begun("--out", tmp_path / "run", "--opponents", "nearest", *SHORT)
    time.sleep(0.5)  # it imports torch
    said = interrupted(process)
    assert said[-1].startswith("catch-arena: interrupted")
    assert not [line for line in said if "Traceback" in line]


@pytest.mark.torch
def test_the_help_says_what_each_setting_means():
    said = " ".join(run("examples/train_ppo.py", "--help").split())
    assert "--hold N Steps for which a decision holds. Default: 2" in said
    assert "--start TEXT An .npz file to begin from. Default: none" in said


@pytest.mark.torch
def test_a_run_that_is_killed_leaves_an_agent_and_goes_on(tmp_path):
    out = tmp_path / "run"
    more = ["--out", out, "--opponents", "nearest", *SHORT]
    command = [sys.executable, ROOT / "examples" / "train_ppo.py", *more, "--decisions", 10**9]
    with subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT) as process:
        late = time.monotonic() + 300
        while not (out / "agent.py").exists() and process.poll() is None and time.monotonic() < late:
            time.sleep(0.1)
        process.kill()
    assert PointerNetwork.load(out / "agent.npz").head == "destination"
    before = len(table(out / "progress.csv"))
    progress = out / "progress.csv"
    _, _, rest = progress.read_text().splitlines()[-1].partition(",")
    with progress.open("a") as file:  # as if it had been killed long after its last snapshot
        file.write(f"{128 * (before + 1)},{rest}\n")
    run("examples/train_ppo.py", *more, "--decisions", 128 * (before + 1), "--resume")
    made = [int(row["decisions"]) for row in table(progress)]
    assert made == [128 * (place + 1) for place in range(before + 1)]


@pytest.mark.torch
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--head tail", "--head must be one of destination, rank, velocity, got 'tail'"),
        ("--arenas 0", "--arenas must be in [1, inf], got 0"),
        ("--gamma nan", "--gamma must be in [0, 1], got nan"),
        ("--rate inf", "not finite: a lower --rate may help"),
        ("--scenarios unequal", "--scenarios must be such that all hunters are alike"),
        ("--scenarios tag", "--scenarios must be such that all hunters are alike and no prey is played"),
        ("--scenarios moon", "moon"),
        ("--opponents nobody", "nobody"),
        ("--imitate patrol", "--imitate needs the head rank or velocity"),
        ("--start gone.npz", "gone.npz"),
        ("--start other.npz --hidden 16", "--hidden must be 8, as in --start, got 16"),
        ("--rate 1e30", "not finite: a lower --rate may help"),
        ("--rate 1e20 --head velocity", "not finite: a lower --rate may help"),
        ("--head rank --imitate patrol", "--imitate must name an agent with act_batch and target control, got patrol"),
        ("--head velocity --imitate contested", "with act_batch and velocity control, got contested"),
        ("--most-selves 0", "--most-selves must be in [1, inf], got 0"),
        ("--seed -1", "--seed must be in [0, 4611686018427387904], got -1"),
        (f"--seed {10**30}", "--seed must be in [0, "),
        ("--evaluate -5", "--evaluate must be in [0, inf], got -5"),
        ("--evaluate-against patrol,nobody", "unknown agent 'nobody'"),
        ("--opponents nearest,", "is a folder without agent.py"),
        ("--horizon 1", "--horizon must be in [2, inf], got 1"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(tmp_path, arguments, said):
    short = [*SHORT, "--out", tmp_path / "run", "--decisions", 512]
    opponents = [] if "--opponents" in arguments else ["--opponents", "nearest"]
    network = tmp_path / "other.npz"
    weights = {name: np.zeros(shape) for name, shape in weight_shapes("destination", 8).items()}
    PointerNetwork("destination", weights).save(network)
    assert said in refused(*short, *opponents, *arguments.replace("other.npz", str(network)).split())


@pytest.mark.torch
@pytest.mark.parametrize("head", ["destination", "velocity"])
def test_the_network_decides_the_same_in_torch_and_in_numpy(module, head):
    import torch

    torch.manual_seed(1)
    trained = module.Network(module.Settings(head=head, hidden=16))
    with torch.no_grad():
        for weights in trained.weights.values():
            weights.normal_(0, 0.3)
    arenas = module.Arenas("standard", module.Settings(head=head, arenas=8, opponents="nearest"), seed=2)
    looked = module.destinations(arenas.view)
    chances, mean, _ = trained(*module.tensors(looked))
    network = trained.exported()
    logits, mixed = network(looked)
    ours = logits - np.log(np.exp(logits.astype(np.float64)).sum(axis=1, keepdims=True))
    np.testing.assert_allclose(chances.detach().numpy()[looked.legal], ours[looked.legal], atol=1e-4)
    if head == "velocity":
        np.testing.assert_allclose(mean.detach().numpy(), network.velocities(logits, mixed), atol=1e-4)


@pytest.mark.torch
def test_advantages_are_the_sums_of_discounted_errors(module):
    """By the definition, in place of the recursion."""
    import torch

    settings = module.Settings(horizon=6, hold=2, gamma=0.9, trace=0.8)
    torch.manual_seed(2)
    values, gained, following = torch.randn(6, 3), torch.randn(6, 3), torch.randn(3)
    ended = (torch.rand(6, 3) < 0.3).float()
    rollout = module.Rollout([], *(torch.zeros(6, 3),) * 3, values, gained, ended, following)
    found = module.advantages_of(rollout, settings)
    gamma = 0.9**2
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
def test_past_selves_that_win_are_met_more_often(module, tmp_path):
    settings = module.Settings(out=tmp_path, arenas=4, opponents="nearest,idle", self_play=0.5, most_selves=2, hidden=8)
    arenas = module.Arenas("duel", settings, seed=1)
    pool = module.Pool([arenas], settings)
    network = module.Network(settings)
    for _ in range(3):
        pool.grow(network.exported())
    assert pool.alive.sum() == 2 + 2
    pool.beaten[:] = (0.1, 0.9, 0.5, 0.2, 0.9)
    pool.alive[:] = True
    pool.weigh()
    weights = arenas.batch.opponents.weights
    assert weights[:2].sum() == pytest.approx(0.5)
    assert weights[0] > weights[1]
    assert weights[3] > weights[2] > weights[4]


@pytest.mark.torch
def test_the_short_example_leaves_an_agent_that_plays(tmp_path):
    said = run("examples/train_sb3.py", "--out", tmp_path / "sb3", "--scenario", "duel", "--steps", 8192)
    assert "check-agent" in said
    made = create_policy(str(tmp_path / "sb3" / "agent.py"))
    assert made.network.inputs == 57
    check = [
        sys.executable,
        "-m",
        "catch_arena",
        "check-agent",
        str(tmp_path / "sb3" / "agent.py"),
        "--scenario",
        "duel",
    ]
    assert "ok" in subprocess.run(check, capture_output=True, text=True, check=True, cwd=ROOT).stdout
