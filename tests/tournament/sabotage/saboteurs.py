"""Agents that harm what holds their tournament, as files that real processes play.

They touch processes of their own tournament alone: those that they descend from, up to the tournament's own and never
beyond it. Where that is, stands in the file `below` beside them: the process that started it.
"""

import os
from pathlib import Path

_COMMON = '''
import os, signal, subprocess, sys, threading, time
from pathlib import Path

HERE = Path(__file__).parent


def parent(pid):
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


def ancestors():
    """From the parent up to the tournament's process; none where that is not among them."""
    below, found = int((HERE / "below").read_text()), [os.getppid()]
    while (above := parent(found[-1])) != below:
        if above <= 1:
            return []
        found.append(above)
    return [] if found[-1] == below else found


def strike(pids, number=signal.SIGKILL):
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass


class Agent:
    def reset(self, seed):
        self.step = 0

    def act(self, view):
        self.step += 1
        self.move()
        return 1 if view.targets else 0

    def move(self):
        pass
'''

_KINDS = {
    # The supervisor is the second above an agent, the first above what imports it.
    "at_import": "strike(ancestors()[:1])\n",
    "at_construction": "class Agent(Agent):\n    def __init__(self): strike(ancestors()[1:2])\n",
    "at_reset": "class Agent(Agent):\n    def reset(self, seed): strike(ancestors()[1:2])\n",
    "in_a_step": "class Agent(Agent):\n    def move(self):\n        if self.step == 12: strike(ancestors()[1:2])\n",
    # the supervisor, the worker above it, and all that is between that and the tournament's own process
    "all_but_the_tournament": "class Agent(Agent):\n    def move(self):\n"
    "        if self.step == 8: strike(ancestors()[1:-1])\n",
    "the_tournament": "class Agent(Agent):\n    def move(self):\n        if self.step == 8: strike(ancestors()[-1:])\n",
    "interrupts_the_tournament": "class Agent(Agent):\n    def move(self):\n"
    "        if self.step == 8: strike(ancestors()[-1:], signal.SIGTERM)\n",
    "stops_the_supervisor": "class Agent(Agent):\n    def move(self):\n"
    "        if self.step == 5: strike(ancestors()[1:2], signal.SIGSTOP)\n",
    "stops_the_worker": "class Agent(Agent):\n    def move(self):\n"
    "        if self.step == 5: strike(ancestors()[2:3], signal.SIGSTOP)\n",
    "the_tournament_at_import": "strike(ancestors()[-1:])\n",
    # all that the supervisor started: the rivals and their fork servers, who die as if by themselves
    "its_rivals": "class Agent(Agent):\n    def move(self):\n        if self.step != 6: return\n"
    "        mine = {os.getpid(), *ancestors()}\n"
    "        top = ancestors()[2:3]  # the worker, from which rivals descend whatever keeps them\n"
    "        family = set(top)\n"
    "        for _ in range(8):\n"
    "            for entry in os.listdir('/proc'):\n"
    "                try:\n"
    "                    if entry.isdigit() and parent(entry) in family: family.add(int(entry))\n"
    "                except OSError: pass\n"
    "        strike(family - mine - set(top))\n",
    # a grandchild in a session of its own waits until its match is over, for the supervisor of those that follow
    "by_a_sleeping_grandchild": "class Agent(Agent):\n    def reset(self, seed):\n        self.step = 0\n"
    "        doomed = ancestors()[1:2]\n"
    "        if os.fork() == 0:\n            os.setsid()\n            time.sleep(0.5)\n            strike(doomed)\n"
    "            os._exit(0)\n",
    # a thread of the fork server lives on between its matches
    "by_a_thread_that_waits": "def wait():\n    above = os.getppid()\n    while True:\n        time.sleep(1.0)\n"
    "        strike([above])\n\nif ancestors():\n    threading.Thread(target=wait, daemon=True).start()\n",
    # leaves a process behind by killing what would end it
    "leaves_an_orphan": "class Agent(Agent):\n    def move(self):\n        if self.step != 4: return\n"
    "        doomed = ancestors()[2:-1]\n        above = ancestors()[1:2]\n"
    "        if os.fork() == 0:\n            os.setsid()\n            strike(above)\n            time.sleep(1.0)\n"
    "            strike(doomed)\n            time.sleep(600)\n        time.sleep(600)\n",
    "fills_the_disk": "class Agent(Agent):\n    def move(self):\n        if self.step != 3: return\n"
    "        for number in range(64):\n            try:\n"
    "                with open(f'{number}', 'wb') as file: file.write(bytes(1 << 20))\n"
    "            except OSError: pass\n",
    "takes_the_memory": "class Agent(Agent):\n    def move(self):\n        if self.step != 3: return\n"
    "        for _ in range(20):\n            if os.fork() == 0:\n                hoard = []\n"
    "                while True: hoard.append(bytearray(b'x' * (4 << 20)))\n        time.sleep(2)\n",
}
KINDS = tuple(_KINDS)


def saboteur(folder: Path, kind: str) -> str:
    """An agent of one of KINDS, for a tournament that this process starts; its path."""
    (folder / "below").write_text(str(os.getpid()))
    path = folder / f"{kind}.py"
    path.write_text(_COMMON + "\n\n" + _KINDS[kind])
    return str(path)


def forfeiter(folder: Path, kind: str) -> str:
    """An agent of the same name that simply forfeits; its path."""
    path = folder / f"{kind}.py"
    path.write_text("class Agent:\n    def reset(self, seed): 1 / 0\n    def act(self, view): return 0\n")
    return str(path)
