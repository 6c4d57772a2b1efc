"""Short runs of the programs in examples/, with their output and the files that they leave."""

import csv
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SHORT = ("--hidden=8", "--evaluate=0", "--seed=3")
SMALL = {"ARENAS": 8, "HORIZON": 16, "MINIBATCH": 64, "SNAPSHOT": 128}
TRAIN = """
from catch_arena import interrupts

interrupts.listen()
import sys

sys.path.insert(0, {folder!r})
import train_ppo, {module}

for module in (train_ppo, {module}):
    vars(module).update({constants!r})
interrupts.run({module}.main)
"""


def output_of(command, *, fails=False):
    """Output of a command, from both channels."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert (done.returncode != 0) == fails, done.stdout + done.stderr
    return done.stdout + done.stderr


def run(script, *arguments, fails=False):
    """Output of a script."""
    return output_of([sys.executable, ROOT / script, *arguments], fails=fails)


def trainer(*arguments, module="train_ppo", **constants):
    """Command of train_ppo.py, or of another trainer, with small constants."""
    code = TRAIN.format(folder=str(ROOT / "examples"), module=module, constants=SMALL | constants)
    return [sys.executable, "-c", code, *map(str, arguments)]


def train(*arguments, **constants):
    """Output of a small run of train_ppo.py, or of the trainer `module`."""
    return output_of(trainer(*arguments, **constants))


def table(path):
    """The rows of a CSV file."""
    with path.open() as file:
        return list(csv.DictReader(file))


def refused(*arguments, **constants):
    """Last line of a run that is refused."""
    printed = output_of(trainer(*arguments, **constants), fails=True)
    assert "Traceback" not in printed
    return printed.splitlines()[-1]


def refused_here(module, arguments, monkeypatch, capsys):
    """Last line of a run in this process that is refused; it need not load torch again."""
    for name, value in SMALL.items():
        monkeypatch.setattr(module, name, value, raising=False)
    monkeypatch.setattr(sys, "argv", [module.__name__, *map(str, arguments)])
    with pytest.raises(SystemExit) as ended:
        module.main()
    printed = capsys.readouterr().err + str(ended.value.code)
    assert "Traceback" not in printed
    return printed.removesuffix("\n2").splitlines()[-1]


def check(agent, scenario="duel"):
    """`catch-arena check-agent` accepts an agent."""
    command = [sys.executable, "-m", "catch_arena", "check-agent", str(agent), "--scenario", scenario]
    assert "ok" in subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT).stdout


def begun(*arguments, **constants):
    """Process of a small run, whose lines can be read."""
    command = trainer(*arguments, **constants)
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )


def interrupted(process):
    """Return its lines after a Ctrl-C."""
    os.killpg(process.pid, signal.SIGINT)
    output = process.communicate(timeout=120)[0].splitlines()
    assert process.returncode == 130
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)  # nothing of it is left
    return output
