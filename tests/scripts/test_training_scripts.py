"""The training examples learn, resume, stop on Ctrl-C, and refuse wrong settings in one line."""

import csv
import importlib.util
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from catch_arena.training.pointer import PointerNetwork, weight_shapes

ROOT = Path(__file__).parents[2]
SHORT = ("--arenas=8", "--horizon=16", "--minibatch=64", "--hidden=8", "--snapshot=128", "--evaluate=0", "--seed=3")


def run(script, *arguments, fails=False):
    """Run a script, and return its output and its errors."""
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
    """Object whose pickle runs code."""

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


def begun(*arguments):
    """train_ppo.py as a process of its own, whose lines can be read."""
    command = [sys.executable, ROOT / "examples" / "train_ppo.py", *arguments]
    return subprocess.Popen(
        list(map(str, command)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )


def interrupted(process):
    """Send Ctrl-C, and return the output after it."""
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
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("--head tail", "--head must be one of destination, rank, velocity, got 'tail'"),
        ("--arenas 0", "--arenas must be in [1, inf], got 0"),
        ("--scenarios tag", "--scenarios must be such that all hunters are alike and no prey is played"),
        ("--start other.npz --hidden 16", "--hidden must be 8, as in --start, got 16"),
        ("--rate 1e30", "not finite: a lower --rate may help"),
        ("--head rank --imitate patrol", "--imitate must name an agent with act_batch and target control, got patrol"),
        ("--seed -1", "--seed must be in [0, 4611686018427387904], got -1"),
        ("--evaluate-against patrol,nobody", "unknown agent 'nobody'"),
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
