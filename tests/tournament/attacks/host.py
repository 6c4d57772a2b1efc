"""Runs tournaments in processes of their own, for the attacks: `harness.Host` starts it.

All is imported once; each line from the standard input is a command to run in a forked process, whose exit code comes
back. Whatever a tournament leaves behind becomes a child of this process.
"""

import ctypes
import json
import os
import sys
import tempfile
import traceback
from contextlib import redirect_stdout, suppress

_SET_CHILD_SUBREAPER = 36


def main():
    """Serve until the input ends."""
    import catch_arena.__main__ as command

    with (
        tempfile.TemporaryDirectory() as folder,
        suppress(SystemExit),
        redirect_stdout(None),
    ):  # loads all that it needs
        words = ["nearest", "idle", "--scenario", "duel", "--set", "time_limit_s=0.4", "--record", "--out", folder]
        command.main(["tournament", *words, "--jobs", "1"])
    ctypes.CDLL(None).prctl(_SET_CHILD_SUBREAPER, 1, 0, 0, 0)
    print("ready", flush=True)
    for line in sys.stdin:
        request = json.loads(line)
        child = os.fork()
        if not child:
            code = 70
            try:
                os.chdir(request["folder"])
                sys.path.append(request["packages"])
                os.environ["PYTHONPATH"] += os.pathsep + request["packages"]
                printed = os.open(request["printed"], os.O_WRONLY | os.O_CREAT)
                for standard in (1, 2):
                    os.dup2(printed, standard)
                os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
                if request["alone"]:
                    os.execv(sys.executable, [sys.executable, "-m", "catch_arena", *request["words"]])
                command.main(request["words"])
            except SystemExit as ended:
                code = ended.code or 0
            except BaseException:
                traceback.print_exc()
            finally:
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code if isinstance(code, int) else 71)
        _, status = os.waitpid(child, 0)
        with suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass
        print(os.waitstatus_to_exitcode(status), flush=True)


if __name__ == "__main__":
    main()
