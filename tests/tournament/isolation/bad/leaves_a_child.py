"""Starts a child that leaves the family: a session of its own, and its parent gone. Prints the child's process id."""

import os
import time


class Agent:
    def reset(self, seed):
        told, tells = os.pipe()
        if os.fork() == 0:
            os.setsid()
            if os.fork() == 0:
                os.write(tells, f"{os.getpid()}".encode())
                time.sleep(3600)
            os._exit(0)
        os.wait()
        print("child", os.read(told, 99).decode())

    def act(self, view):
        return 0
