"""A real tournament of four agents, played once, with every match recorded."""

import pytest
from command_line import run


@pytest.fixture(scope="session")
def played(tmp_path_factory):
    """Folder of the tournament."""
    folder = tmp_path_factory.mktemp("tournament")
    agents = ["nearest", "contested", "patrol", "first"]
    words = [
        "--set",
        "time_limit_s=10",
        "--set",
        "reach_m=0.8",
        "--scenario",
        "standard",
        "--record",
        "--seed",
        "0",
        "--jobs",
        "1",
    ]
    words += ["--rounds", "1", "--out", str(folder)]
    done = run("tournament", *agents, *words)
    assert done.exit_code == 0, done.output
    return folder
