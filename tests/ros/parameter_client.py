"""`ros2 param`, as a node that knows the wire and no more: a client of each service of a node's parameters."""

import time

from ros import cdr, wire

NOT_SET, BOOL, INTEGER, DOUBLE, STRING = range(5)


def put_value(writer, kind=NOT_SET, value=None, arrays=((), (), (), (), ())):
    """ParameterValue: four single values, of which the type says one, and five arrays."""
    writer.number("B", kind)
    writer.number("?", value if kind == BOOL else False)
    writer.number("q", value if kind == INTEGER else 0)
    writer.number("d", value if kind == DOUBLE else 0.0)
    writer.text(value if kind == STRING else "")
    for code, array in zip("B?qds", arrays, strict=True):
        writer.number("I", len(array))
        for one in array:
            writer.text(one) if code == "s" else writer.number(code, one)
    return writer


def take_value(reader):
    """(type, the value of that type), where no array has anything in it."""
    kind = reader.number("B")
    values = None, reader.number("?"), reader.number("q"), reader.number("d"), reader.text()
    assert [reader.number("I") for _ in range(5)] == [0, 0, 0, 0, 0]
    return kind, values[kind]


class ParameterClient:
    """Waits until all six services are there, as rclpy's client does."""

    def __init__(self, domain, node, seconds=240.0):
        own = wire.Node(domain)
        self.ends = {name: own.client(f"/{node}/{name}", kind) for name, kind in wire.parameter_services().items()}
        assert len(self.ends) == 6
        self.number = 0
        end = time.monotonic() + seconds
        while not all(one.matched() for ends in self.ends.values() for one in ends):
            assert time.monotonic() < end, "the services do not appear"
            time.sleep(0.01)

    def ask(self, service, fill):
        """A request; what it is answered is for `answer`."""
        asks, _ = self.ends[service]
        self.number += 1
        writer = cdr.begin(asks.handle, self.number)
        fill(writer)
        asks.write(writer.whole())

    def answer(self, service, seconds=240.0):
        """The response to the last request, behind its header; None where none comes."""
        asks, answers = self.ends[service]
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for data in answers.take():
                reader = cdr.Reader(data)
                if (reader.number("Q"), reader.number("q")) == (asks.handle, self.number):
                    return reader
            time.sleep(0.005)
        return None

    def call(self, service, fill):
        self.ask(service, fill)
        reader = self.answer(service)
        assert reader is not None, f"{service} is not answered"
        return reader

    def names(self, service, names):
        """A request that is a list of names."""

        def fill(writer):
            writer.number("I", len(names))
            for name in names:
                writer.text(name)

        return self.call(service, fill)

    def list(self, *prefixes):
        def fill(writer):
            writer.number("I", len(prefixes))
            for prefix in prefixes:
                writer.text(prefix)
            writer.number("Q", 0)

        reader = self.call("list_parameters", fill)
        found = [reader.text() for _ in range(reader.number("I"))]
        assert reader.number("I") == 0
        return found

    def get(self, *names):
        reader = self.names("get_parameters", names)
        return [take_value(reader) for _ in range(reader.number("I"))]

    def types(self, *names):
        reader = self.names("get_parameter_types", names)
        return [reader.number("B") for _ in range(reader.number("I"))]

    def describe(self, *names):
        """(name, type, description, constraints, read only) of each."""
        reader = self.names("describe_parameters", names)
        found = []
        for _ in range(reader.number("I")):
            told = reader.text(), reader.number("B"), reader.text(), reader.text(), reader.number("?")
            assert reader.number("?") is False
            assert (reader.number("I"), reader.number("I")) == (0, 0)
            found.append(told)
        return found

    def set(self, *changes, service="set_parameters"):
        """(name, type, value) each: whether it was done, and why not."""

        def fill(writer):
            writer.number("I", len(changes))
            for name, *value in changes:
                put_value(writer.text(name), *value)

        reader = self.call(service, fill)
        count = 1 if service == "set_parameters_atomically" else reader.number("I")
        return [(reader.number("?"), reader.text()) for _ in range(count)]
