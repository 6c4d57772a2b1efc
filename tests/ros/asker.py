"""Asks for names of some lengths, and prints each answer, or None if none came before the last one.

Arguments: domain, service, lengths.
"""

import sys
import time
from itertools import count

from ros import cdr, wire


def main(domain, service, *lengths):
    asks, answers = wire.Node(int(domain)).client(service, wire.catch_turtle())
    told, numbers = {}, count()

    def ask(length):
        number = next(numbers)
        asks.write(cdr.begin(asks.handle, number).text("x" * int(length)).whole())
        return number

    def hear():
        time.sleep(0.01)
        for data in answers.take():
            reader = cdr.Reader(data)
            if reader.number("Q") == asks.handle:
                number = reader.number("q")
                told[number] = reader.number("?")

    while not (asks.matched() and answers.matched()):
        time.sleep(0.01)
    while not told:  # an answer is lost as long as the other side does not know the reader of its answers
        ask(1)
        hear()
    asked = [ask(length) for length in lengths]
    while asked[-1] not in told:  # answers come in order
        hear()
    for number in asked:
        sys.stdout.write(f"{told.get(number)}\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
