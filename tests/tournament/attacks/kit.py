"""What every attacker brings along. Its text stands at the top of each attacking agent's file, so it uses Python's own
modules only.

It is careful with this machine: an attacker looks at the processes of its own tournament alone, which ends below the
process that runs the tests.
"""

import os
import re
import traceback
from pathlib import Path

FACTS: dict = {}
"""What an attacker may know already, such as paths that it could guess; filled in by the harness."""
ATTACKS: list = []
"""What this one tries, a function each; filled in by the harness."""


def tell(what):
    """Say what was found out, in the agent's log."""
    print(f"found {what}", flush=True)


def parent_of(pid):
    """The parent of a process; 0 where there is none to be seen."""
    try:
        return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])
    except OSError:
        return 0


def ancestors():
    """Its fork server, the supervisor, the tournament: as far as they are seen, and never beyond the tournament."""
    found, pid = [], os.getppid()
    while pid > 1 and pid != FACTS["tests"]:
        found.append(pid)
        pid = parent_of(pid)
    if pid == FACTS["tests"] or in_a_process_tree_of_its_own():
        return found
    return []  # above it are processes that are none of the tournament's


def in_a_process_tree_of_its_own():
    """Whether its process numbers are not those of the tests."""
    return os.readlink("/proc/self/ns/pid") != FACTS["process tree"]


def relatives():
    """All processes of its own tournament that are seen, itself left out."""
    roots = {*ancestors(), os.getpid()}
    parents = {int(name): parent_of(name) for name in os.listdir("/proc") if name.isdigit()}
    while more := {pid for pid, parent in parents.items() if parent in roots} - roots:
        roots |= more
    return sorted(roots - {os.getpid()})


def siblings():
    """The other agents' processes, and their fork servers'; not its own ancestors and children."""
    line = {*ancestors(), os.getpid()}
    return [pid for pid in relatives() if pid not in line and parent_of(pid) != os.getpid()]


def secrets_in(content):
    """What looks like somebody's secret."""
    return sorted({found.decode() for found in re.findall(rb"SECRET-[0-9a-f]{32}", content)})


def secret_of_mine():
    """What an accomplice has beside its source."""
    return (Path(__file__).parent / "rival_weights.txt").read_bytes()


def memory_of(pid):
    """The places of a process's private memory that it can write, small ones first: (begin, end)."""
    spans = []
    with open(f"/proc/{pid}/maps") as maps:
        for line in maps:
            span, rights, *_ = line.split()
            if rights.startswith("rw") and "[v" not in line:
                begin, end = (int(number, 16) for number in span.split("-"))
                spans.append((begin, end))
    return sorted(spans, key=lambda span: span[1] - span[0])


class Agent:
    """From its second move of every match on, it attacks, once a move; it holds still otherwise."""

    def reset(self, seed):
        self.seed = seed
        self.to_try = [None, *ATTACKS]
        print("works in", os.getcwd(), flush=True)

    def act(self, view):
        attack = self.to_try.pop(0) if self.to_try else None
        if attack is not None:
            print("tries", attack.__name__, flush=True)
            try:
                attack(self)
            except Exception:
                traceback.print_exc()
        return 0
