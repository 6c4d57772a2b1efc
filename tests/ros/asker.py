"""Asks for names of some lengths, one after the other, and prints each answer; None where none comes.

Arguments: domain, service, lengths.
"""

import sys
import time

from ros import cdr, wire

WAIT_S = 2.0


def main(domain, service, *lengths):
    asks, answers = wire.Node(int(domain)).client(service, wire.catch_turtle())
    while not (asks.matched() and answers.matched()):
        time.sleep(0.01)
    time.sleep(0.2)  # the other side knows the reader of its answers too
    for number, length in enumerate(lengths):
        asks.write(cdr.begin(asks.handle, number).text("x" * int(length)).whole())
        sys.stdout.write(f"{answer(asks, answers, number)}\n")


def answer(asks, answers, number):
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        for data in answers.take():
            reader = cdr.Reader(data)
            if (reader.number("Q"), reader.number("q")) == (asks.handle, number):
                return reader.number("?")
        time.sleep(0.01)
    return None


if __name__ == "__main__":
    main(*sys.argv[1:])
